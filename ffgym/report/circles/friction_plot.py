"""Friction over speed, and speed, error and feedback of one axis over time: thesis Figures 4.2 to 4.5 and 5.11."""

from typing import TYPE_CHECKING, Any

import numpy as np

from ffgym.core.types import Array, BoolArray
from ffgym.recordings import Recording
from ffgym.recordings.metrics import friction_miss, motor_error, relative_rms
from ffgym.report.figure import ReportFigure, panels
from ffgym.report.laws import LawStyle, baseline_of, law_styles, list_compensated
from ffgym.studies import CircleStudy, OneAxisStudy
from ffgym.studies.one_axis import SETTLED

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_TRUE: dict[str, Any] = {"color": "black", "linewidth": 1.8, "label": "friction of the robot"}
SHOWN = 2.0
"""Length of the stretch of time that is drawn [s], after the start has settled."""


def one_axis_loops_figure(study: OneAxisStudy) -> ReportFigure:
    """Draw friction over speed on one axis: one row per frequency, one column per law that compensates."""
    laws, frequencies = (list(dict.fromkeys(part)) for part in zip(*study.recordings, strict=True))
    styles, columns = law_styles(laws), list_compensated(laws)
    size, misses = (max(4.4 * len(columns), 5.0), 2.9 * len(frequencies) + 0.4), []
    with panels(len(frequencies), len(columns), size=size, sharex="row", sharey="row") as (figure, grid):
        for i, frequency in enumerate(frequencies):
            for axes, law in zip(grid[i], columns, strict=True):
                recording = study.recordings[law, frequency]
                # loops of friction over speed, without the transient at the beginning
                rows = recording.t >= SETTLED
                _draw_over_speed(axes, recording, 0, rows, None)
                _draw_over_speed(axes, recording, 0, rows, styles[law])
                axes.set_title(f"{styles[law].label}, {frequency:g} Hz")
                axes.set_xlabel("motor speed of the reference [rad/s]")
                misses.append(f"{styles[law].label} at {frequency:g} Hz {friction_miss(recording, rows)[0]:.1%}")
            grid[i][0].set_ylabel("friction torque [N m]")
    return ReportFigure(
        name="one-axis-friction",
        title="Friction of one axis over speed",
        caption="Friction of the motor (black) and what the law adds (colour), over the speed of the reference, "
        f"without the first {SETTLED:g} s. RMS of their difference, in percent of the RMS friction: "
        f"{', '.join(misses)}.",
        figure=figure,
        thesis="Figures 4.2 (1 Hz) and 4.4 (3 Hz)",
    )


def joint_loops_figure(study: CircleStudy, *, beside: str | None = None) -> ReportFigure:
    """Draw one panel per joint and law that compensates, laws side by side, at the first position and speed.

    `beside` names a law whose torque is drawn in every panel instead of the friction of the robot.
    """
    agents, (position, *_), (speed, *_) = (list(dict.fromkeys(part)) for part in zip(*study.recordings, strict=True))
    columns = [law for law in list_compensated(agents) if law != beside]
    styles, joints, misses = law_styles(agents), study.robot.joints, []
    size = max(4.2 * len(columns), 5.0), 1.75 * len(joints) + 0.7
    with panels(len(joints), len(columns), size=size, sharex="row", sharey="row") as (figure, grid):
        for j, law in enumerate(columns):
            recording = study.recordings[law, position, speed]
            moving = ~recording.mask(kind="standstill")
            other = recording if beside is None else study.recordings[beside, position, speed]
            for i, joint in enumerate(joints):
                _draw_over_speed(grid[i][j], other, i, moving, None if beside is None else styles[beside], width=1.8)
                _draw_over_speed(grid[i][j], recording, i, moving, styles[law])
                grid[i][j].set_title(f"{joint}, {styles[law].label}", fontsize=9)
                grid[i][0].set_ylabel("torque [N m]")
            grid[-1][j].set_xlabel("motor speed of the reference [rad/s]")
            shares = friction_miss(recording) if beside is None else unlike(recording, other)
            each = ", ".join(f"{joint} {share:.1%}" for joint, share in zip(joints, shares, strict=True))
            misses.append(f"{styles[law].label}: {each}")
    # caption, with the differences of each law
    place = f"motor side, at {position}, {speed * 1e3:g} mm/s, without standstill"
    if beside is None:
        caption = (
            f"Friction of each joint (black) and what the law adds (colour), {place}. Friction bends with the real "
            "speed, the law with that of the reference. RMS of their difference, in percent of the RMS friction: "
        )
    else:
        caption = (
            f"What the law adds, and what {styles[beside].label} adds on the same motion, {place}. RMS of their "
            f"difference, in percent of the RMS of {styles[beside].label}: "
        )
    return ReportFigure(
        name="joint-friction",
        title="Friction of each joint over speed",
        caption=f"{caption}{'; '.join(misses)}.",
        figure=figure,
        thesis="in the manner of Figure 5.11",
    )


def unlike(recording: Recording, other: Recording) -> Array:
    """Compute RMS difference of two laws' torques on one motion over RMS of the other, without standstill, (N,)."""
    moving = ~recording.mask(kind="standstill")
    added, others = (part.joint_array("compensation.effort")[moving] for part in (recording, other))
    return relative_rms(added - others, others)


def _draw_over_speed(
    axes: "Axes", recording: Recording, joint: int, rows: BoolArray, law: LawStyle | None, width: float = 1.1
) -> None:
    """Draw a law's torque, or without a law the friction of the robot, over the reference's motor speed [rad/s]."""

    def column(family: str) -> Array:
        """Select samples, with NaN where a stretch of rows ends, so that no line is drawn across."""
        values = np.where(rows, recording.joint_array(family)[:, joint], np.nan)
        return values[rows | np.roll(rows, 1)]

    speed = column("reference.velocity")
    if law is None:
        axes.plot(speed, column("friction.effort"), **_TRUE)
    else:
        look: dict[str, Any] = {"color": law.colour, "linestyle": law.line, "linewidth": width}
        axes.plot(speed, column("compensation.effort"), label=f"added by {law.label}", **look)


def one_axis_figure(study: OneAxisStudy, frequency: float) -> ReportFigure:
    """Draw speed, error and feedback torque in rows, one column per law that compensates, at `frequency` [Hz]."""
    laws = [law for law, f in study.recordings if f == frequency]
    styles, columns, before = law_styles(laws), list_compensated(laws), baseline_of(laws)
    with panels(3, len(columns), size=(max(4.6 * len(columns), 5.0), 6.2), sharex=True, sharey="row") as (figure, grid):
        for j, law in enumerate(columns):
            for name in dict.fromkeys((before, law)):
                recording, style = study.recordings[name, frequency], styles[name]
                rows = (recording.t >= SETTLED) & (recording.t <= SETTLED + SHOWN)
                signals: tuple[Array, ...] = (
                    recording.joint_array("motor.velocity"),
                    motor_error(recording) * 1e3,
                    recording.joint_array("feedback.effort"),
                )
                look: dict[str, Any] = {"color": style.colour, "linestyle": style.line, "label": style.label}
                for axes, signal in zip(grid[:, j], signals, strict=True):
                    axes.plot(recording.t[rows], signal[rows, 0], **look)
                    axes.set_xlim(SETTLED, SETTLED + SHOWN)
            grid[0][j].set_title(f"{styles[law].label}, {frequency:g} Hz")
            grid[2][j].set_xlabel("time [s]")
        for row, label in zip(grid, ("motor speed [rad/s]", "motor error [mrad]", "feedback $u_c$ [N m]"), strict=True):
            row[0].set_ylabel(label)
        figure.align_ylabels()
    # RMS error of each law, for the caption
    values = []
    for result in study.results:
        if result.frequency_hz == frequency:
            less = f"{abs(result.reduction):.1%} {'less' if result.reduction >= 0 else 'more'}"
            gone = "" if result.agent == before else f" ({less})"
            values.append(f"{styles[result.agent].label} {result.motor_rms_rad * 1e3:.2f} mrad{gone}")
    return ReportFigure(
        name=f"one-axis-{frequency:g}-hz",
        title=f"One axis on a sine of {frequency:g} Hz",
        caption=f"One axis following a sine of {frequency:g} Hz, {SHOWN:g} s after the start has settled: speed, motor "
        f"position error and feedback torque, before ({styles[before].label}) and after. RMS motor error: "
        f"{'; '.join(values)}.",
        figure=figure,
        thesis={1.0: "Figure 4.3", 3.0: "Figure 4.5"}.get(frequency, "not shown at this frequency"),
    )
