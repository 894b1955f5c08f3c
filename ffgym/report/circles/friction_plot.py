"""Friction over speed, and speed, error and feedback of one axis over time: thesis Figures 4.2 to 4.5 and 5.11."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ffgym.core.types import Array, BoolArray
from ffgym.recordings import Recording
from ffgym.recordings.metrics import friction_miss, motor_error, relative_rms
from ffgym.report.figure import panels
from ffgym.report.laws import LawStyle, baseline_of, compensated, law_styles
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
    with panels(
        len(frequencies),
        len(columns),
        size=(max(4.4 * len(columns), 5.0), 2.9 * len(frequencies) + 0.4),
        sharex="row",
        sharey="row",
    ) as (figure, grid):
        for i, frequency in enumerate(frequencies):
            for j, law in enumerate(columns):
                recording = study.recordings[law, frequency]
                rows = recording.t >= SETTLED
                _draw_friction(grid[i][j], recording, 0, rows)
                _draw_added(grid[i][j], recording, 0, rows, styles[law])
                grid[i][j].set_title(f"{styles[law].label}, {frequency:g} Hz")
                grid[i][j].set_xlabel("motor speed of the reference [rad/s]")
            grid[i][0].set_ylabel("friction torque [N m]")
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
    with panels(
        len(joints),
        len(columns),
        size=(max(4.2 * len(columns), 5.0), 1.75 * len(joints) + 0.7),
        sharex="row",
        sharey="row",
    ) as (figure, grid):
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


SHOWN = 2.0
"""Length of the stretch that is drawn [s], after the start has settled."""


def one_axis_figure(study: OneAxisStudy, frequency: float) -> "Figure":
    """Three rows (speed, error, feedback torque), one column per law that compensates, at `frequency` [Hz]."""
    laws = [law for law, f in study.recordings if f == frequency]
    styles, columns = law_styles(laws), compensated(laws)
    before = baseline_of(laws)
    with panels(3, len(columns), size=(max(4.6 * len(columns), 5.0), 6.2), sharex=True, sharey="row") as (figure, grid):
        for j, law in enumerate(columns):
            for name in dict.fromkeys((before, law)):
                _draw_signals([grid[i][j] for i in range(3)], study.recordings[name, frequency], styles[name])
            grid[0][j].set_title(f"{styles[law].label}, {frequency:g} Hz")
            grid[2][j].set_xlabel("time [s]")
        for row, label in zip(grid, ("motor speed [rad/s]", "motor error [mrad]", "feedback $u_c$ [N m]"), strict=True):
            row[0].set_ylabel(label)
        figure.align_ylabels()
    return figure


def one_axis_caption(study: OneAxisStudy, frequency: float) -> str:
    """What the figure shows, with error and what of it is gone."""
    results = [result for result in study.results if result.frequency_hz == frequency]
    styles = law_styles(result.agent for result in results)
    before = baseline_of([result.agent for result in results])
    values = "; ".join(
        f"{styles[result.agent].label} {result.motor_rms_rad * 1e3:.2f} mrad"
        + ("" if result.agent == before else f" ({abs(result.reduction):.1%} {_way(result.reduction)})")
        for result in results
    )
    return (
        f"One axis following a sine of {frequency:g} Hz, {SHOWN:g} s after the start has settled: speed, motor "
        f"position error and feedback torque, before ({styles[before].label}) and after. RMS motor error: {values}."
    )


def _way(reduction: float) -> str:
    return "less" if reduction >= 0 else "more"


def _draw_signals(column: "list[Axes]", recording: Recording, style: LawStyle) -> None:
    rows = (recording.t >= SETTLED) & (recording.t <= SETTLED + SHOWN)
    signals: tuple[Array, ...] = (
        recording.joint_array("motor.velocity")[:, 0],
        motor_error(recording)[:, 0] * 1e3,
        recording.joint_array("feedback.effort")[:, 0],
    )
    for axes, signal in zip(column, signals, strict=True):
        axes.plot(recording.t[rows], signal[rows], color=style.colour, linestyle=style.line, label=style.label)
        axes.set_xlim(SETTLED, SETTLED + SHOWN)
