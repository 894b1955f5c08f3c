"""Figures of learning: error over trials, learning at several rates, and many laws beside each other."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from ffgym.core.errors import FFGymError, check_shape
from ffgym.core.types import Array, ComplexArray
from ffgym.report.figure import ReportFigure, panels
from ffgym.report.laws import law_styles
from ffgym.report.page import words_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@dataclass(frozen=True, kw_only=True, eq=False)
class TrialCurves:
    """Curves of one panel."""

    title: str
    errors: Array
    """Error on each of C circles in each of J trials, > 0, in the unit of the figure, shape (J, C)."""
    levels: Mapping[str, float] = field(default_factory=dict)
    """Errors of laws that do not learn, by name: lines to compare with."""

    def __post_init__(self) -> None:
        errors = check_shape(f"errors of {self.title!r}", self.errors, (None, None))
        if errors.size == 0 or (errors <= 0).any():
            raise FFGymError(
                f"errors of {self.title!r} must be at least one trial and circle, all > 0, for a logarithm."
            )
        object.__setattr__(self, "errors", errors)


def trials_figure(curves: Sequence[TrialCurves], label: str) -> "Figure":
    """Draw panels side by side, logarithmic: a thin line per circle, dots for the median, dashes for other laws.

    Args:
        curves: curves of each panel.
        label: label of the error, with its unit.

    Raises:
        FFGymError: if there is no panel.
    """
    if not curves:
        raise FFGymError("There is nothing to draw: curves is empty.")
    styles = law_styles(name for panel in curves for name in panel.levels)
    with panels(1, len(curves), size=(max(3.4 * len(curves), 4.0), 3.4), sharey=True) as (figure, grid):
        for axes, panel in zip(grid[0], curves, strict=True):
            trials, median = np.arange(1, len(panel.errors) + 1), np.median(panel.errors, axis=1)
            for k, errors in enumerate(panel.errors.T):
                axes.plot(trials, errors, color="#9aa5b1", linewidth=0.7, label="each circle" if k == 0 else None)
            axes.plot(trials, median, "o-", color="black", markersize=3.5, label="median circle")
            axes.set_yscale("log")
            axes.set_xticks(trials[:: 1 + len(trials) // 11])
            axes.set_xlabel("trial")
            axes.set_title(panel.title)
            for name, level in panel.levels.items():
                axes.axhline(level, color=styles[name].colour, linestyle="--", label=styles[name].label)
        grid[0, 0].set_ylabel(label)
    return figure


_COLOURS = ("#0072B2", "#009E73", "#E69F00", "#D55E00", "#CC79A7", "#56B4E9")
"""Colours of rates in ascending order, shades of Okabe and Ito."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LearningCurves:
    """Learning of one joint at G rates over I iterations."""

    title: str
    rates: Array
    """Learning rates, ascending, shape (G,)."""
    predicted: Array
    """Mean square of the learning signal [(N m)^2] at first and after each iteration, shape (G, I + 1)."""
    simulated: Array
    """Mean square of the learning signal in simulation, shape (G, I + 1)."""
    eigenvalues: ComplexArray
    """Eigenvalues of one iteration at rate 1, shape (K,)."""
    largest_rate: float
    """Largest stable rate."""

    def __post_init__(self) -> None:
        rates = check_shape("rates", self.rates, (None,))
        if np.any(np.diff(rates) <= 0):
            raise FFGymError(f"rates = {rates.tolist()} must ascend.")
        for name in ("predicted", "simulated"):
            check_shape(name, getattr(self, name), (len(rates), None))


def learning_figure(curves: Sequence[LearningCurves]) -> ReportFigure:
    """Draw one row per joint: learning signal over iterations, and eigenvalues in the complex plane."""
    size, ratios = (10.0, 2.9 * len(curves) + 0.3), (1.4, 1.0)
    with panels(len(curves), 2, size=size, legend=False, width_ratios=ratios) as (figure, grid):
        for (left, right), each in zip(grid, curves, strict=True):
            _draw_curves(left, each)
            _draw_eigenvalues(right, each)
        figure.align_ylabels(grid[:, 0])
    limits = "; ".join(f"{each.title}: {each.largest_rate:.2f}" for each in curves)
    return ReportFigure(
        name="learning",
        title="Learning at several rates",
        caption=words_of("learning")["caption"].format(limits=limits),
        figure=figure,
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


_LOOKS = (("#009E73", "o"), ("#E69F00", "s"), ("#D55E00", "^"))
"""Colour and marker by speed, slowest first."""


def agents_figure(errors: Mapping[str, Sequence[float]], speeds_mm_s: Sequence[float]) -> "Figure":
    """Draw one line per law, one dot per TCP speed, at most three: mean RMS path errors [mm] by the law's words."""
    with panels(size=(10.0, 0.32 * len(errors) + 1.3)) as (figure, grid):
        axes = grid[0, 0]
        for k, (speed, (colour, marker)) in enumerate(zip(speeds_mm_s, _LOOKS, strict=False)):
            values = [each[k] for each in errors.values()]
            axes.plot(values, range(len(errors)), marker, color=colour, label=f"{speed:g} mm/s")
        axes.set_xscale("log")
        axes.set_yticks(range(len(errors)), list(errors))
        axes.invert_yaxis()
        axes.set_xlabel("mean RMS path error [mm]")
    return figure
