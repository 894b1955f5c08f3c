"""Learning at several rates, predicted and simulated, beside the eigenvalues that decide whether it is stable."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ffgym.core.errors import FFGymError, check_shape
from ffgym.core.types import Array, ComplexArray
from ffgym.report.figure import house_style, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_COLOURS = ("#0072B2", "#009E73", "#E69F00", "#D55E00", "#CC79A7", "#56B4E9")
"""Of rates in ascending order, shades of Okabe and Ito."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LearningCurves:
    """Learning of one joint at G rates over I iterations."""

    title: str
    rates: Array
    """Learning rates, ascending, shape (G,)."""
    predicted: Array
    """Mean square of the learning signal [(N m)^2] at first and after each iteration, shape (G, I + 1)."""
    simulated: Array
    """The same in simulation, shape (G, I + 1)."""
    eigenvalues: ComplexArray
    """Of one iteration at rate 1, shape (K,)."""
    largest_rate: float
    """Largest stable rate."""

    def __post_init__(self) -> None:
        rates = check_shape("rates", self.rates, (None,))
        if np.any(np.diff(rates) <= 0):
            raise FFGymError(f"rates = {rates.tolist()} must ascend.")
        for name in ("predicted", "simulated"):
            check_shape(name, getattr(self, name), (len(rates), None))


def learning_figure(curves: Sequence[LearningCurves]) -> "Figure":
    """One row per joint: the learning signal over iterations, and the eigenvalues in the complex plane."""
    with house_style():
        figure = new_figure(10.0, 2.9 * len(curves) + 0.3)
        grid = figure.subplots(len(curves), 2, squeeze=False, width_ratios=(1.4, 1.0))
        for (left, right), each in zip(grid, curves, strict=True):
            _draw_curves(left, each)
            _draw_eigenvalues(right, each)
        figure.align_ylabels(grid[:, 0])
    return figure


def learning_caption(curves: Sequence[LearningCurves]) -> str:
    """What the figure shows, with the largest stable rates."""
    limits = "; ".join(f"{each.title}: {each.largest_rate:.2f}" for each in curves)
    return (
        "Left: mean square of the learning signal over that of the first trial at several learning rates, predicted "
        "from the robot's description (lines) and simulated (dots). Right: eigenvalues of one iteration at rate 1. A "
        "rate is stable if all lie within the circle through 0 about 1 / rate, drawn for the largest stable rate and "
        f"for the largest rate on the left. Largest stable rates: {limits}."
    )


def _draw_curves(axes: "Axes", curves: LearningCurves) -> None:
    iterations = np.arange(curves.predicted.shape[1])
    for k, rate in enumerate(curves.rates):
        colour = _COLOURS[k % len(_COLOURS)]
        predicted, simulated = (part[k] / part[k, 0] for part in (curves.predicted, curves.simulated))
        axes.plot(iterations, predicted, color=colour, label=f"{rate:.2g}")
        axes.plot(iterations, simulated, "o", color=colour, markersize=3.5)
    axes.set_yscale("log")
    axes.set_title(curves.title)
    axes.set_xlabel("iteration")
    axes.set_ylabel("mean square of the signal,\nrelative to trial 0")
    axes.legend(
        title="learning rate\n(lines: predicted,\ndots: simulated)", loc="center left", bbox_to_anchor=(1.0, 0.5)
    )


def _draw_eigenvalues(axes: "Axes", curves: LearningCurves) -> None:
    circle = 1 + np.exp(1j * np.linspace(0, 2 * np.pi, 400))
    fastest = float(curves.rates[-1])
    lines = ((curves.largest_rate, "black", "-", " (limit)"), (fastest, "#D55E00", "--", ""))
    for rate, colour, line, words in lines:
        around = circle / rate
        axes.plot(around.real, around.imag, color=colour, linestyle=line, label=f"{rate:.2f}{words}")
    axes.plot(curves.eigenvalues.real, curves.eigenvalues.imag, "o", color="#0072B2", markersize=3, label="eigenvalues")
    axes.set_aspect("equal")
    axes.set_xlabel("real part")
    axes.set_ylabel("imaginary part")
    axes.legend(title="learning rate", loc="center left", bbox_to_anchor=(1.0, 0.5))
