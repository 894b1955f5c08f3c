"""Motor errors per joint and law, and simulated over published path error: thesis Figures 4.6b to 4.12b."""

from typing import TYPE_CHECKING

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.recordings.metrics import motor_error_rms
from ffgym.report.circles.comparison import FACTOR, SpeedTable, circle_tables, nearness
from ffgym.report.figure import ReportFigure, panels
from ffgym.report.laws import LawStyle, law_styles
from ffgym.studies import CircleStudy

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_LOW = 0.03
"""Share of the highest bar below which a bar has its number above it, as it is too low to see."""


def motor_error_figure(study: CircleStudy) -> ReportFigure:
    """Draw bars per joint and law [mrad], motor side, without standstill: one column per speed, one row per position.

    Shown are the first and the third position, as in the thesis, if there are as many.
    """
    laws, positions, speeds = (list(dict.fromkeys(part)) for part in zip(*study.recordings, strict=True))
    rows, joints, styles = positions[::2][:2], study.robot.joints, law_styles(laws)
    width, places = 0.8 / len(laws), np.arange(len(joints))
    errors = {where: motor_error_rms(recording) * 1e3 for where, recording in study.recordings.items()}
    size = max(4.0 * len(speeds), 5.0), 2.5 * len(rows) + 0.5
    with panels(len(rows), len(speeds), size=size, sharey="col") as (figure, grid):
        for i, position in enumerate(rows):
            for axes, speed in zip(grid[i], speeds, strict=True):
                highest = max(float(errors[law, position, speed].max()) for law in laws)
                for k, law in enumerate(laws):
                    values = errors[law, position, speed]
                    x = places + (k - (len(laws) - 1) / 2) * width
                    axes.bar(x, values, width * 0.92, color=styles[law].colour, label=styles[law].label)
                    for left, value in zip(x, values, strict=True):
                        number = f"{value:.2g}" if value < _LOW * highest else ""
                        axes.annotate(number, (left, value), (0, 2), textcoords="offset points", ha="center", size=6.5)
                axes.set_xticks(places, joints)
                axes.grid(axis="x", visible=False)
                axes.set_title(f"{position}, {speed * 1e3:g} mm/s")
            grid[i][0].set_ylabel("RMS motor error [mrad]")
    # joint with the largest error at each speed, for the caption
    peaks = []
    for speed in speeds:
        joint = int(np.argmax(errors[laws[0], rows[0], speed]))
        each = ", ".join(f"{errors[law, rows[0], speed][joint]:.2f} mrad with {styles[law].label}" for law in laws)
        peaks.append(f"at {speed * 1e3:g} mm/s joint {joints[joint]}: {each}")
    return ReportFigure(
        name="motor-errors",
        title="Motor position error per joint",
        caption="RMS of the motor position error (reference minus motor), motor side, over the whole motion without "
        "standstill. Scales differ between speeds; numbers stand over bars too low to see. "
        f"Joint that strays most with {styles[laws[0]].label} at {rows[0]}: {'; '.join(peaks)}.",
        figure=figure,
        thesis="Figures 4.6b to 4.9b (simulated), 4.10b to 4.12b (real robot)",
    )


_TICKS = tuple(digit * 10.0**power for power in range(-4, 4) for digit in (1, 2, 5))


def ratios_figure(study: CircleStudy) -> ReportFigure:
    """Draw one panel per speed with published numbers, one dot per circle and law; the band is a factor of FACTOR."""
    tables = [table for table in circle_tables(study) if table.is_published]
    if not tables:
        raise FFGymError(
            "No published path error for any circle of this study; Tables 4.1 and 4.2 have 10 and 40 mm/s."
        )
    styles = law_styles(tables[0].agents)
    size = max(0.42 * len(tables[0].rows), 2.5) * len(tables) + 1.0, 3.9
    with panels(1, len(tables), size=size, sharey=True) as (figure, grid):
        for axes, table in zip(grid[0], tables, strict=True):
            _draw_ratios(axes, table, styles)
        # one logarithmic scale for all panels, with room for every ratio and for the band
        ratios = [ratio for table in tables for agent in styles for ratio in table.ratios(agent).values()]
        low, high = min(*ratios, 1 / FACTOR) / 1.5, max(*ratios, FACTOR) * 1.5
        ticks = [tick for tick in _TICKS if low <= tick <= high]
        first = grid[0, 0]
        first.set_yscale("log")
        first.set_yticks(ticks, [f"{tick:g}" for tick in ticks])
        first.minorticks_off()
        first.set_ylim(low, high)
        first.set_ylabel("RMS path error, simulated / published")
    # circles in the band, for the caption
    counts = []
    for table in tables:
        for agent, style in styles.items():
            near = nearness(table.ratios(agent).values())
            if near is not None:
                count = f"{near.near} of {near.total} (median {near.median:.2f})"
                counts.append(f"{style.label} at {table.speed_mm_s:g} mm/s {count}")
    return ReportFigure(
        name="ratios",
        title="How near the simulated robot is to the published one",
        caption="RMS path error of the simulated robot over that published for the real one; logarithmic scale. On the "
        f"line they are equal, in the band within a factor of {FACTOR:g}. In the band: {'; '.join(counts)}.",
        figure=figure,
        thesis="Tables 4.1, 4.2, 5.1 and 5.2",
    )


def _draw_ratios(axes: "Axes", table: SpeedTable, styles: dict[str, LawStyle]) -> None:
    """Draw ratios at one speed, circles ordered by position, then radius."""
    positions, radii = (list(dict.fromkeys(getattr(r, name) for r in table.rows)) for name in ("position", "radius_mm"))
    places = {
        (radius, position): i * len(radii) + k for i, position in enumerate(positions) for k, radius in enumerate(radii)
    }
    axes.axhspan(1 / FACTOR, FACTOR, color="#e8e8e8", zorder=0, label=f"within a factor of {FACTOR:g}")
    axes.axhline(1, color="#444444", linewidth=0.8, zorder=1)
    for k, (agent, style) in enumerate(styles.items()):
        ratios = table.ratios(agent)
        x = [places[key] + 0.18 * (k - (len(styles) - 1) / 2) for key in ratios]
        axes.plot(x, list(ratios.values()), style.marker, color=style.colour, label=style.label, zorder=3)
    axes.set_xlim(-0.6, len(places) - 0.4)
    axes.set_xticks(range(len(places)), [f"{radius:g}" for radius, _ in places])
    axes.grid(axis="x", visible=False)
    axes.set_title(f"{table.speed_mm_s:g} mm/s")
    # names of positions below the radii, and a line between positions
    for i, position in enumerate(positions):
        middle = (i * len(radii) + (len(radii) - 1) / 2, 0)
        coords = ("data", "axes fraction")
        axes.annotate(position, middle, (0, -22), xycoords=coords, textcoords="offset points", ha="center")
        if i:
            axes.axvline(i * len(radii) - 0.5, color="#bbbbbb", linewidth=0.8)
    axes.set_xlabel("radius [mm], position", labelpad=18)
