"""Motor errors per joint and law, and simulated over published path error: thesis Figures 4.6b to 4.12b."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.recordings.metrics import motor_error_rms
from ffgym.report.circles.comparison import FACTOR, SpeedTable, circle_tables, nearness
from ffgym.report.figure import panels
from ffgym.report.laws import LawStyle, law_styles
from ffgym.studies import CircleStudy

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def shown_positions(study: CircleStudy) -> list[str]:
    """First and third position of a study, as in the thesis, or what there is of them."""
    return list(dict.fromkeys(position for _, position, _ in study.recordings))[::2][:2]


def motor_error_figure(study: CircleStudy, *, positions: Sequence[str] | None = None) -> "Figure":
    """Bars per joint and law [mrad], motor side, standstill excluded: one column per speed, one row per position."""
    laws, _, speeds = (list(dict.fromkeys(part)) for part in zip(*study.recordings, strict=True))
    rows = shown_positions(study) if positions is None else list(positions)
    styles = law_styles(laws)
    with panels(len(rows), len(speeds), size=(max(4.0 * len(speeds), 5.0), 2.5 * len(rows) + 0.5), sharey="col") as (
        figure,
        grid,
    ):
        for i, position in enumerate(rows):
            for j, speed in enumerate(speeds):
                _draw_bars(grid[i][j], _errors(study, laws, position, speed), study.robot.joints, styles)
                grid[i][j].set_title(f"{position}, {speed * 1e3:g} mm/s")
            grid[i][0].set_ylabel("RMS motor error [mrad]")
    return figure


def motor_error_caption(study: CircleStudy) -> str:
    """What the figure shows, and the joint that strays most at every speed of its first position."""
    laws, _, speeds = (list(dict.fromkeys(part)) for part in zip(*study.recordings, strict=True))
    styles = law_styles(laws)
    position = shown_positions(study)[0]
    peaks = []
    for speed in speeds:
        errors = _errors(study, laws, position, speed)
        joint = int(np.argmax(errors[laws[0]]))
        values = ", ".join(f"{errors[law][joint]:.2f} mrad with {styles[law].label}" for law in laws)
        peaks.append(f"at {speed * 1e3:g} mm/s joint {study.robot.joints[joint]}: {values}")
    return (
        "RMS of the motor position error (reference minus motor), motor side, over the whole motion without "
        "standstill. Scales differ between speeds; numbers stand over bars too low to see. "
        f"Joint that strays most with {styles[laws[0]].label} at {position}: {'; '.join(peaks)}."
    )


def _errors(study: CircleStudy, laws: Sequence[str], position: str, speed: float) -> dict[str, Array]:
    """RMS motor error by law [mrad], shape (N,) each."""
    return {law: motor_error_rms(study.recordings[law, position, speed]) * 1e3 for law in laws}


def _draw_bars(axes: "Axes", errors: dict[str, Array], joints: Sequence[str], styles: dict[str, LawStyle]) -> None:
    width = 0.8 / len(errors)
    places = np.arange(len(joints))
    for k, (law, values) in enumerate(errors.items()):
        x = places + (k - (len(errors) - 1) / 2) * width
        axes.bar(x, values, width * 0.92, color=styles[law].colour, label=styles[law].label)
        for left, value in zip(x, values, strict=True):
            axes.annotate(_low(value, errors), (left, value), (0, 2), textcoords="offset points", ha="center", size=6.5)
    axes.set_xticks(places, joints)
    axes.grid(axis="x", visible=False)


def _low(value: float, errors: dict[str, Array]) -> str:
    """Number over a bar that is too low to see."""
    return f"{value:.2g}" if value < 0.03 * max(float(values.max()) for values in errors.values()) else ""


_TICKS = tuple(digit * 10.0**power for power in range(-4, 4) for digit in (1, 2, 5))


def ratios_figure(study: CircleStudy) -> "Figure":
    """One panel per speed with published numbers, one dot per circle and law; the band is a factor of FACTOR.

    Raises:
        FFGymError: if nothing was published for the circles of the study.
    """
    tables = [table for table in circle_tables(study) if table.is_published]
    if not tables:
        raise FFGymError(
            "No published path error for any circle of this study; Tables 4.1 and 4.2 have 10 and 40 mm/s."
        )
    styles = law_styles(tables[0].agents)
    with panels(1, len(tables), size=(max(0.42 * len(tables[0].rows), 2.5) * len(tables) + 1.0, 3.9), sharey=True) as (
        figure,
        grid,
    ):
        row = grid[0]
        for axes, table in zip(row, tables, strict=True):
            _draw_ratios(axes, table, styles)
        _set_scale(row[0], [ratio for table in tables for agent in styles for ratio in table.ratios(agent).values()])
        row[0].set_ylabel("RMS path error, simulated / published")
    return figure


def ratios_caption(study: CircleStudy) -> str:
    """What the figure shows, with the count inside the band for every speed and law."""
    counts = []
    for table in circle_tables(study):
        for agent, style in law_styles(table.agents).items():
            near = nearness(table.ratios(agent).values())
            if near is not None:
                counts.append(
                    f"{style.label} at {table.speed_mm_s:g} mm/s {near.near} of {near.total} (median {near.median:.2f})"
                )
    return (
        "RMS path error of the simulated robot over that published for the real one; logarithmic scale. On the line "
        f"they are equal, in the band within a factor of {FACTOR:g}. In the band: {'; '.join(counts)}."
    )


def _draw_ratios(axes: "Axes", table: SpeedTable, styles: dict[str, LawStyle]) -> None:
    places = {(radius, position): x for x, (position, radius) in enumerate(_order(table))}
    axes.axhspan(1 / FACTOR, FACTOR, color="#e8e8e8", zorder=0, label=f"within a factor of {FACTOR:g}")
    axes.axhline(1, color="#444444", linewidth=0.8, zorder=1)
    for k, (agent, style) in enumerate(styles.items()):
        ratios = table.ratios(agent)
        x = [places[key] + 0.18 * (k - (len(styles) - 1) / 2) for key in ratios]
        axes.plot(x, list(ratios.values()), style.marker, color=style.colour, label=style.label, zorder=3)
    axes.set_xlim(-0.6, len(places) - 0.4)
    axes.set_xticks(range(len(places)), [f"{radius:g}" for _, radius in _order(table)])
    axes.grid(axis="x", visible=False)
    axes.set_title(f"{table.speed_mm_s:g} mm/s")
    _name_positions(axes, table)


def _set_scale(axes: "Axes", ratios: list[float]) -> None:
    """Logarithmic, with room for every ratio and for the band; other panels share it."""
    low, high = min(*ratios, 1 / FACTOR) / 1.5, max(*ratios, FACTOR) * 1.5
    ticks = [tick for tick in _TICKS if low <= tick <= high]
    axes.set_yscale("log")
    axes.set_yticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.minorticks_off()
    axes.set_ylim(low, high)


def _name_positions(axes: "Axes", table: SpeedTable) -> None:
    """Position names below the radii, and a line between positions."""
    n = len(table.radii)
    for i, position in enumerate(table.positions):
        middle = i * n + (n - 1) / 2
        axes.annotate(
            position, (middle, 0), (0, -22), xycoords=("data", "axes fraction"), textcoords="offset points", ha="center"
        )
        if i:
            axes.axvline(i * n - 0.5, color="#bbbbbb", linewidth=0.8)
    axes.set_xlabel("radius [mm], position", labelpad=18)


def _order(table: SpeedTable) -> list[tuple[str, float]]:
    """Circles along the axis: by position, then radius [mm]."""
    return [(position, radius) for position in table.positions for radius in table.radii]
