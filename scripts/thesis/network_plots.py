"""Figures of networks that learn: basis, training, and what the feedback does: thesis Figures 5.2 to 5.18."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ffgym.core.errors import FFGymError, check_shape
from ffgym.core.types import Array
from ffgym.recordings import Recording
from ffgym.report.figure import panels

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def basis_figure(speeds: Array, values: Array, close_up: float) -> "Figure":
    """All basis functions, and those near zero speed.

    Args:
        speeds: motor speeds [rad/s], ascending, shape (T,).
        values: basis functions there, shape (T, S).
        close_up: half of the range of the second panel [rad/s].
    """
    with panels(1, 2, size=(10.0, 2.6), sharey=True) as (figure, grid):
        both = grid[0]
        for axes, reach in zip(both, (float(speeds[-1]), close_up), strict=True):
            axes.plot(speeds, values, linewidth=0.9)
            axes.set(xlim=(-reach, reach), xlabel="motor speed [rad/s]")
        both[0].set(title="all splines", ylabel="value")
        both[1].set_title(f"within ±{close_up:g} rad/s")
    return figure


_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
"""One per joint, shades of Okabe and Ito."""
_MARKERS = ("o", "s", "^", "D", "v", "P")


@dataclass(frozen=True, kw_only=True, eq=False)
class Training:
    """How one law learned, K trials of N joints; the first trial is before learning."""

    title: str
    error: Array
    """Mean square motor position error [rad^2], shape (K, N)."""
    signal: Array
    """Mean square learning signal [(N m)^2], shape (K, N)."""

    def __post_init__(self) -> None:
        error = check_shape(f"error of {self.title!r}", self.error, (None, None))
        signal = check_shape(f"signal of {self.title!r}", self.signal, error.shape)
        if not len(error) or np.any(error[0] <= 0) or np.any(signal[0] <= 0):
            raise FFGymError(f"{self.title!r}: the first trial must have errors above 0, others are relative to it.")
        object.__setattr__(self, "error", error)
        object.__setattr__(self, "signal", signal)

    @property
    def left(self) -> dict[str, Array]:
        """Mean squares over those of the first trial, of 'error' and of 'signal', shape (K, N) each."""
        return {"error": self.error / self.error[0], "signal": self.signal / self.signal[0]}


_ROWS = (("error", "position error $e_p$"), ("signal", "learning signal $u_p$"))


def training_figure(trainings: Sequence[Training], joints: Sequence[str]) -> "Figure":
    """Normalised mean squares on a logarithmic scale: two rows, one column per law, one line per joint."""
    with panels(
        2,
        len(trainings),
        size=(max(4.4 * len(trainings), 5.0), 5.2),
        legend=len(joints) > 1,
        sharex="col",
        sharey="row",
    ) as (figure, grid):
        for j, training in enumerate(trainings):
            for i, (name, words) in enumerate(_ROWS):
                axes, left = grid[i][j], training.left[name]
                for k, joint in enumerate(joints):
                    colour, marker = _COLOURS[k % len(_COLOURS)], _MARKERS[k % len(_MARKERS)]
                    axes.plot(left[:, k], color=colour, marker=marker, markersize=3.5, label=joint)
                axes.set_yscale("log")
                grid[i][0].set_ylabel(f"mean square of\n{words} / first")
            grid[0][j].set_title(training.title)
            grid[1][j].set_xlabel("iteration")
            grid[1][j].xaxis.get_major_locator().set_params(integer=True)
    return figure


def training_caption(trainings: Sequence[Training], joints: Sequence[str]) -> str:
    """What the figure shows, and what is left after the last trial."""
    ends = []
    for training in trainings:
        each = ", ".join(
            f"{joint} {error:.2g} and {signal:.2g}"
            for joint, error, signal in zip(
                joints, training.left["error"][-1], training.left["signal"][-1], strict=True
            )
        )
        ends.append(f"{training.title}: {each}")
    return (
        "Mean squares of motor position error and learning signal without standstill, over those of the first trial, "
        "which has no compensation; logarithmic. A joint that no longer improves is locked, so that its line goes on "
        f"level. Left at the end (error and signal): {'; '.join(ends)}."
    )


_COLUMNS = 3
_TOTAL, _WITHOUT_INTEGRAL = "#D55E00", "#0072B2"


def feedback_over_speed_figure(recording: Recording) -> "Figure":
    """Feedback torque over motor speed, one panel per joint, standstill left out."""
    joints = recording.header.joints
    moving = ~recording.mask(kind="standstill")
    speed = np.where(moving[:, None], recording.joint_array("reference.velocity"), np.nan)
    feedback = recording.joint_array("feedback.effort")
    n_rows = -(-len(joints) // _COLUMNS)
    with panels(n_rows, _COLUMNS, size=(10.0, 2.3 * n_rows)) as (figure, grid):
        for axes, joint in zip(grid.flat, range(len(joints)), strict=False):
            axes.plot(speed[:, joint], feedback[:, joint], color=_TOTAL, linewidth=0.9)
            axes.set_title(joints[joint])
        for axes in grid.flat[len(joints) :]:
            axes.set_visible(False)
        for row in grid:
            row[0].set_ylabel("feedback $u_c$ [N m]")
        for axes in grid[-1]:
            axes.set_xlabel("motor speed of the reference [rad/s]")
    return figure


def feedback_parts_figure(recording: Recording, joint: int) -> "Figure":
    """Feedback torque of one joint (counted from 0) over time, with and without its integral part."""
    feedback = recording.joint_array("feedback.effort")[:, joint]
    proportional = feedback - recording.joint_array("feedback.integral")[:, joint]
    with panels(size=(10.0, 3.0)) as (figure, grid):
        axes = grid[0, 0]
        axes.plot(recording.t, feedback, color=_TOTAL, label="feedback $u_c$")
        axes.plot(recording.t, proportional, color=_WITHOUT_INTEGRAL, label="without its integral part, $u_p$")
        axes.set(xlabel="time [s]", ylabel=f"torque of {recording.header.joints[joint]} [N m]")
    return figure
