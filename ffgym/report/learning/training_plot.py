"""Mean squares of motor error and learning signal over iterations: thesis Figures 5.6, 5.10 and 5.18."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ffgym.core.errors import FFGymError, check_shape
from ffgym.core.types import Array
from ffgym.report.figure import house_style, legend_above, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

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
    with house_style():
        figure = new_figure(max(4.4 * len(trainings), 5.0), 5.2)
        grid = figure.subplots(2, len(trainings), squeeze=False, sharex="col", sharey="row")
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
        if len(joints) > 1:
            legend_above(figure, *grid[0][0].get_legend_handles_labels())
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
