"""Friction over speed, true and as a law predicts it: thesis Figures 4.2, 4.4 and 5.11."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ffgym.core.types import Array, BoolArray
from ffgym.recordings import Recording
from ffgym.recordings.metrics import friction_miss, relative_rms
from ffgym.report.figure import house_style, legend_above, new_figure
from ffgym.report.laws import LawStyle, compensated, law_styles
from ffgym.studies import CircleStudy, OneAxisStudy
from ffgym.studies.one_axis import SETTLED

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_TRUE: dict[str, Any] = {"color": "black", "linewidth": 1.8, "label": "friction of the robot"}


def one_axis_loops_figure(study: OneAxisStudy) -> "Figure":
    """One row per frequency, one column per law that compensates."""
    laws, frequencies = (list(dict.fromkeys(part)) for part in zip(*study.recordings, strict=True))
    styles = law_styles(laws)
    columns = compensated(laws)
    with house_style():
        figure = new_figure(max(4.4 * len(columns), 5.0), 2.9 * len(frequencies) + 0.4)
        grid = figure.subplots(len(frequencies), len(columns), squeeze=False, sharex="row", sharey="row")
        for i, frequency in enumerate(frequencies):
            for j, law in enumerate(columns):
                recording = study.recordings[law, frequency]
                rows = recording.t >= SETTLED
                _draw_friction(grid[i][j], recording, 0, rows)
                _draw_added(grid[i][j], recording, 0, rows, styles[law])
                grid[i][j].set_title(f"{styles[law].label}, {frequency:g} Hz")
                grid[i][j].set_xlabel("motor speed of the reference [rad/s]")
            grid[i][0].set_ylabel("friction torque [N m]")
        _legend(figure, grid[0])
    return figure


def joint_loops_figure(
    study: CircleStudy,
    *,
    position: str | None = None,
    speed: float | None = None,
    laws: Sequence[str] | None = None,
    beside: str | None = None,
) -> "Figure":
    """One panel per joint and law that compensates, laws side by side, at one position and speed.

    Args:
        study: the circle test.
        position: name; None takes the first.
        speed: TCP speed [m/s]; None takes the first.
        laws: names; None takes all that compensate.
        beside: name of a law whose torque is drawn in every panel instead of the friction of the robot.
    """
    agents, positions, speeds = (list(dict.fromkeys(part)) for part in zip(*study.recordings, strict=True))
    where = (position or positions[0], speed or speeds[0])
    columns = [law for law in compensated(agents) if law != beside] if laws is None else list(laws)
    styles, joints = law_styles(agents), study.robot.joints
    with house_style():
        figure = new_figure(max(4.2 * len(columns), 5.0), 1.75 * len(joints) + 0.7)
        grid = figure.subplots(len(joints), len(columns), squeeze=False, sharex="row", sharey="row")
        for j, law in enumerate(columns):
            recording = study.recordings[(law, *where)]
            moving = ~recording.mask(kind="standstill")
            for i, joint in enumerate(joints):
                if beside is None:
                    _draw_friction(grid[i][j], recording, i, moving)
                else:
                    _draw_added(grid[i][j], study.recordings[(beside, *where)], i, moving, styles[beside], width=1.8)
                _draw_added(grid[i][j], recording, i, moving, styles[law])
                grid[i][j].set_title(f"{joint}, {styles[law].label}", fontsize=9)
                grid[i][0].set_ylabel("torque [N m]")
            grid[-1][j].set_xlabel("motor speed of the reference [rad/s]")
        _legend(figure, grid[0])
    return figure


def one_axis_loops_caption(study: OneAxisStudy) -> str:
    """What the figure shows, with how far each law is from the friction."""
    laws, frequencies = (list(dict.fromkeys(part)) for part in zip(*study.recordings, strict=True))
    styles = law_styles(laws)
    misses = []
    for frequency in frequencies:
        for law in compensated(laws):
            recording = study.recordings[law, frequency]
            miss = friction_miss(recording, recording.t >= SETTLED)[0]
            misses.append(f"{styles[law].label} at {frequency:g} Hz {miss:.1%}")
    return (
        "Friction of the motor (black) and what the law adds (colour), over the speed of the reference, without the "
        f"first {SETTLED:g} s. RMS of their difference, in percent of the RMS friction: {', '.join(misses)}."
    )


def joint_loops_caption(study: CircleStudy, beside: str | None = None) -> str:
    """What the figure shows, with how far each law is from the friction of each joint, or from the law `beside`."""
    agents, positions, speeds = (list(dict.fromkeys(part)) for part in zip(*study.recordings, strict=True))
    where = (positions[0], speeds[0])
    styles = law_styles(agents)
    misses = []
    for law in compensated(agents):
        if law != beside:
            recording = study.recordings[(law, *where)]
            shares = (
                friction_miss(recording) if beside is None else unlike(recording, study.recordings[(beside, *where)])
            )
            each = ", ".join(f"{joint} {share:.1%}" for joint, share in zip(study.robot.joints, shares, strict=True))
            misses.append(f"{styles[law].label}: {each}")
    place = f"motor side, at {positions[0]}, {speeds[0] * 1e3:g} mm/s, without standstill"
    if beside is not None:
        return (
            f"What the law adds, and what {styles[beside].label} adds on the same motion, {place}. RMS of their "
            f"difference, in percent of the RMS of {styles[beside].label}: {'; '.join(misses)}."
        )
    return (
        f"Friction of each joint (black) and what the law adds (colour), {place}. Friction bends with the real speed, "
        "the law with that of the reference. RMS of their difference, in percent of the RMS friction: "
        f"{'; '.join(misses)}."
    )


def unlike(recording: Recording, other: Recording) -> Array:
    """RMS difference of what two laws add on one motion over RMS of the other, without standstill, shape (N,)."""
    moving = ~recording.mask(kind="standstill")
    added, others = (part.joint_array("compensation.effort")[moving] for part in (recording, other))
    return relative_rms(added - others, others)


def _draw_friction(axes: "Axes", recording: Recording, joint: int, rows: BoolArray) -> None:
    axes.plot(_speed(recording, joint, rows), _column(recording, "friction.effort", joint, rows), **_TRUE)


def _draw_added(
    axes: "Axes", recording: Recording, joint: int, rows: BoolArray, style: LawStyle, width: float = 1.1
) -> None:
    added = _column(recording, "compensation.effort", joint, rows)
    look: dict[str, Any] = {"color": style.colour, "linestyle": style.line, "linewidth": width}
    axes.plot(_speed(recording, joint, rows), added, label=f"added by {style.label}", **look)


def _speed(recording: Recording, joint: int, rows: BoolArray) -> Array:
    """Motor speed of the reference [rad/s]."""
    return _column(recording, "reference.velocity", joint, rows)


def _column(recording: Recording, family: str, joint: int, rows: BoolArray) -> Array:
    """One joint's samples, NaN where a stretch of rows ends, so that no line is drawn across."""
    values = np.where(rows, recording.joint_array(family)[:, joint], np.nan)
    return values[rows | np.roll(rows, 1)]


def _legend(figure: "Figure", row: "Sequence[Axes]") -> None:
    found = [axes.get_legend_handles_labels() for axes in row]
    entries = {label: handle for handles, labels in found for handle, label in zip(handles, labels, strict=True)}
    legend_above(figure, list(entries.values()), list(entries))
