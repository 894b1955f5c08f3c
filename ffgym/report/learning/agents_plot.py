"""Mean path error of many laws at every speed, on one logarithmic axis."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from ffgym.report.figure import house_style, legend_above, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_LOOKS = (("#009E73", "o"), ("#E69F00", "s"), ("#D55E00", "^"))
"""Colour and marker by speed, slowest first."""


def agents_figure(errors: Mapping[str, Sequence[float]], speeds_mm_s: Sequence[float]) -> "Figure":
    """One line per law, one dot per speed.

    Args:
        errors: mean RMS path error [mm] at each speed, by the law's words.
        speeds_mm_s: TCP speeds, at most three.
    """
    with house_style():
        figure = new_figure(10.0, 0.32 * len(errors) + 1.3)
        axes = figure.subplots()
        for k, (speed, (colour, marker)) in enumerate(zip(speeds_mm_s, _LOOKS, strict=False)):
            values = [each[k] for each in errors.values()]
            axes.plot(values, range(len(errors)), marker, color=colour, label=f"{speed:g} mm/s")
        axes.set_xscale("log")
        axes.set_yticks(range(len(errors)), list(errors))
        axes.invert_yaxis()
        axes.set_xlabel("mean RMS path error [mm]")
        legend_above(figure, *axes.get_legend_handles_labels())
    return figure
