"""What is gained: residuals before and after, beside the noise floor."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ffgym.diagnosis.result import Level
from ffgym.report.diagnosis.models import EXTENDED, FINE, LOOKS, NOMINAL
from ffgym.report.figure import house_style, legend_above, new_figure
from ffgym.report.table import shortened

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MARGIN = 1.6
"""Factor of room above the largest and below the smallest value."""


def levels_figure(levels: Sequence[Level]) -> "Figure":
    """One panel for each channel: RMS of each component, from before to after."""
    channels = list(dict.fromkeys(level.channel for level in levels))
    with house_style():
        figure = new_figure(7.6, 2.0 * len(channels) + 0.6)
        panels = figure.subplots(len(channels), 1, squeeze=False)[:, 0]
        for axes, channel in zip(panels, channels, strict=True):
            _draw(axes, [level for level in levels if level.channel == channel])
            axes.set_ylabel(f"{channel} [{axes.get_ylabel()}]")
        legend_above(figure, *panels[0].get_legend_handles_labels())
        figure.align_ylabels()
    return figure


def _draw(axes: "Axes", levels: Sequence[Level]) -> None:
    """Levels of one channel; the label of the upright axis is their unit."""
    at = np.arange(len(levels))
    factors, units = zip(*(FINE[level.unit] for level in levels), strict=True)
    before, after, floor = (
        np.array(factors) * [getattr(level, name) for level in levels] for name in ("before", "after", "noise_floor")
    )
    axes.hlines(floor, at - 0.3, at + 0.3, color="black", linewidth=1.4, label="noise floor")
    axes.vlines(at, after, before, color="#b9c0c9", linewidth=2.0, zorder=1)
    for name, values, marker in ((NOMINAL, before, "o"), (EXTENDED, after, "D")):
        axes.plot(at, values, marker, color=LOOKS[name]["color"], markersize=7, label=name)
    axes.set_xticks(at, [shortened(level.component) for level in levels])
    axes.set_xlim(-0.6, len(levels) - 0.4)
    axes.set_yscale("log")
    known = np.concatenate([before, after, floor])
    axes.set_ylim(known.min() / _MARGIN, known.max() * _MARGIN)
    axes.set_ylabel(", ".join(dict.fromkeys(units)))
