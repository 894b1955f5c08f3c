"""Curves of friction before and after a network went on learning at some speeds only: thesis 3.2."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from ffgym.core.types import Array
from ffgym.report.figure import house_style, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def forgetting_figure(speed: Array, panels: Mapping[str, tuple[Array, Array]], *, seen_from: float) -> "Figure":
    """One panel per network: torque [N m] before and after, over motor speed [rad/s]; what came again is shaded.

    Args:
        speed: ascending, shape (T,).
        panels: torque before and after by the name of the network, shape (T,) each.
        seen_from: speed from which on the motor ran again [rad/s].
    """
    with house_style():
        figure = new_figure(4.2 * len(panels), 3.2)
        grid = figure.subplots(1, len(panels), squeeze=False, sharey=True)[0]
        for axes, (name, (before, after)) in zip(grid, panels.items(), strict=True):
            axes.axvspan(seen_from, float(speed[-1]), color="#eeeeee")
            axes.plot(speed, before, color="#888888", label="all speeds learned")
            axes.plot(speed, after, color="#c0392b", label="after the shaded speeds alone")
            axes.set_title(name)
            axes.set_xlabel("motor speed [rad/s]")
        grid[0].set_ylabel("torque [N m]")
        figure.legend(*grid[0].get_legend_handles_labels(), loc="outside upper center", ncols=2)
    return figure
