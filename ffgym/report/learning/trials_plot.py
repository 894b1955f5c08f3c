"""Error over trials, for whatever learns from trial to trial."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from ffgym.core.errors import FFGymError, check_shape
from ffgym.core.types import Array
from ffgym.report.figure import house_style, legend_above, new_figure
from ffgym.report.laws import law_styles

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@dataclass(frozen=True, kw_only=True, eq=False)
class TrialCurves:
    """What one panel shows."""

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


def trials_figure(panels: Sequence[TrialCurves], label: str) -> "Figure":
    """One panel beside the other, logarithmic: a thin line per circle, dots for the median, dashes for other laws.

    Args:
        panels: what to show.
        label: of the error, with its unit.

    Raises:
        FFGymError: if there is no panel.
    """
    if not panels:
        raise FFGymError("There is nothing to draw: panels is empty.")
    styles = law_styles(name for panel in panels for name in panel.levels)
    with house_style():
        figure = new_figure(max(3.4 * len(panels), 4.0), 3.4)
        row = figure.subplots(1, len(panels), squeeze=False, sharey=True)[0]
        for axes, panel in zip(row, panels, strict=True):
            _draw(axes, panel)
            for name, level in panel.levels.items():
                axes.axhline(level, color=styles[name].colour, linestyle="--", label=styles[name].label)
        row[0].set_ylabel(label)
        entries = {text: line for axes in row for line, text in zip(*axes.get_legend_handles_labels(), strict=True)}
        legend_above(figure, list(entries.values()), list(entries))
    return figure


def _draw(axes: "Axes", panel: TrialCurves) -> None:
    trials = np.arange(1, len(panel.errors) + 1)
    for k, errors in enumerate(panel.errors.T):
        axes.plot(trials, errors, color="#9aa5b1", linewidth=0.7, label="each circle" if k == 0 else None)
    axes.plot(trials, np.median(panel.errors, axis=1), "o-", color="black", markersize=3.5, label="median circle")
    axes.set_yscale("log")
    axes.set_xticks(trials[:: 1 + len(trials) // 11])
    axes.set_xlabel("trial")
    axes.set_title(panel.title)
