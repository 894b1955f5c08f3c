"""Friction of NARX networks beside that of the LuGre model they were fitted to: thesis Figures 6.10 and 6.11."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.identification.narx import Samples
from ffgym.report.figure import house_style, legend_above, new_figure
from ffgym.report.laws import law_styles
from scripts.thesis.narx import ESTIMATION, VALIDATION, NarxFit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SHOWN = 2.0
"""Length that is drawn [s], the last of each record, where the start is forgotten; a period at 0.5 Hz."""
_MARGIN = 1.3
"""Torque axis over the largest friction: networks that run away leave the picture."""
_APART = 0.15
"""Between marks of one record, which is 1 wide."""
_MARKERS = "osD^v<>p"
_TRUE: dict[str, Any] = {"color": "black", "linewidth": 1.8, "label": "LuGre model"}


def narx_figure(fit: NarxFit, records: Mapping[str, Samples]) -> "Figure":
    """Free run over time (left) and over motor speed (right), on estimation (top) and validation data (bottom)."""
    with house_style():
        figure = new_figure(9.6, 5.6)
        grid = figure.subplots(2, 2, sharex="col", sharey="row")
        for row, name in zip(grid, (ESTIMATION, VALIDATION), strict=True):
            what = "estimation" if name == ESTIMATION else "validation"
            _draw_row(row, fit, records[name])
            row[0].set(title=f"{what}, {name}, over time", ylabel="friction torque [N m]")
            row[1].set_title(f"{what}, {name}, over speed")
        grid[1][0].set_xlabel("time [s]")
        grid[1][1].set_xlabel("motor speed [rad/s]")
        handles, labels = grid[0][0].get_legend_handles_labels()
        legend_above(figure, handles, labels)
    return figure


def _draw_row(row: "Sequence[Axes]", fit: NarxFit, samples: Samples) -> None:
    n_starts = fit.model.n_joints
    shown = slice(-round(SHOWN / samples.dt) - 1, None)
    t = samples.dt * np.arange(len(samples.torque))[shown]
    speed, torque = samples.motor_dq[shown, 0], samples.torque[shown, 0]
    networks = fit.model.simulated(np.repeat(samples.motor_dq, n_starts, axis=1))[shown]
    colour = law_styles(["narx"])["narx"].colour
    for axes, x in zip(row, (t, speed), strict=True):
        axes.plot(x, torque, **_TRUE)
        axes.plot(x, networks, color=colour, linewidth=0.6, alpha=0.5)
        axes.plot(x, networks[:, fit.typical], color=colour, linewidth=1.5, label="network, median start")
        axes.plot([], [], color=colour, linewidth=0.6, alpha=0.5, label="the other starts")
        size = _MARGIN * float(np.abs(torque).max())
        axes.set_ylim(-size, size)


def fits_figure(fits: Mapping[str, Array], floor: Array, records: Sequence[str]) -> "Figure":
    """Fit in free run on each record, one mark per network, with the static curve as floor.

    Args:
        fits: by label, fit [%] of each start, shape (S, records); marks are medians, bars reach from the worst
            start to the best.
        floor: fit of the static curve [%], shape (records,).
        records: their names.
    """
    with house_style():
        figure = new_figure(9.6, 4.2)
        axes = figure.subplots()
        x = np.arange(len(records))
        axes.plot(x, floor, color="black", linestyle="none", marker="_", markersize=22, label="static curve")
        for i, (label, values) in enumerate(fits.items()):
            middle = np.median(values, axis=0)
            reach = np.abs(np.quantile(values, [0, 1], axis=0) - middle)
            places = x + _APART * (i - (len(fits) - 1) / 2)
            axes.errorbar(places, middle, reach, fmt=_MARKERS[i], markersize=4, elinewidth=0.8, label=label)
        axes.set(ylim=(0, 102), ylabel="fit in free run [%]")
        axes.set_xticks(x, records, rotation=35, ha="right")
        legend_above(figure, *axes.get_legend_handles_labels())
    return figure
