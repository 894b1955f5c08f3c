"""RMS of the motor position error per joint and law: thesis Figures 4.6b to 4.12b."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ffgym.core.types import Array
from ffgym.recordings.metrics import motor_error_rms
from ffgym.report.figure import house_style, legend_above, new_figure
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
    with house_style():
        figure = new_figure(max(4.0 * len(speeds), 5.0), 2.5 * len(rows) + 0.5)
        grid = figure.subplots(len(rows), len(speeds), squeeze=False, sharey="col")
        for i, position in enumerate(rows):
            for j, speed in enumerate(speeds):
                _draw(grid[i][j], _errors(study, laws, position, speed), study.robot.joints, styles)
                grid[i][j].set_title(f"{position}, {speed * 1e3:g} mm/s")
            grid[i][0].set_ylabel("RMS motor error [mrad]")
        legend_above(figure, *grid[0][0].get_legend_handles_labels())
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


def _draw(axes: "Axes", errors: dict[str, Array], joints: Sequence[str], styles: dict[str, LawStyle]) -> None:
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
