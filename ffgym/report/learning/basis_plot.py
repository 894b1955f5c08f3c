"""Basis functions of a B-spline network over motor speed: thesis Figure 5.3."""

from typing import TYPE_CHECKING

from ffgym.core.types import Array
from ffgym.report.figure import house_style, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def basis_figure(speeds: Array, values: Array, close_up: float) -> "Figure":
    """All basis functions, and those near zero speed.

    Args:
        speeds: motor speeds [rad/s], ascending, shape (T,).
        values: basis functions there, shape (T, S).
        close_up: half of the range of the second panel [rad/s].
    """
    with house_style():
        figure = new_figure(10.0, 2.6)
        both = figure.subplots(1, 2, sharey=True)
        for axes, reach in zip(both, (float(speeds[-1]), close_up), strict=True):
            axes.plot(speeds, values, linewidth=0.9)
            axes.set(xlim=(-reach, reach), xlabel="motor speed [rad/s]")
        both[0].set(title="all splines", ylabel="value")
        both[1].set_title(f"within ±{close_up:g} rad/s")
    return figure
