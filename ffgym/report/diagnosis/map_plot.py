"""Where the model is wrong: residual over noise floor as coloured cells, before and after."""

from collections.abc import Mapping
from itertools import groupby
from typing import TYPE_CHECKING

import numpy as np

from ffgym.diagnosis.regimes import ResidualMap
from ffgym.report._matplotlib import house_style, new_figure, require_matplotlib
from ffgym.report.circles.tables import shortened

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import LogNorm
    from matplotlib.figure import Figure

LEAST, MOST = 1.0, 100.0
"""Ratios of the palest and the darkest cell; chosen: noise is pale, a hundred times as much dark."""

_COLOURS = "OrRd"
_UNKNOWN = "#eceff3"
"""Cells of which the log says too little."""

_CELL, _ROW = 0.5, 0.32
"""Width and height of a cell [inch]."""

_DARK = 0.55
"""Share of the colours from which figures in a cell are white."""


def map_figure(maps: Mapping[str, ResidualMap]) -> "Figure":
    """One panel for each map, by what it is called; all have the same components and places."""
    first = next(iter(maps.values()))
    rows, columns = len(first.components), len(first.places)
    with house_style():
        height = len(maps) * (_ROW * rows + 0.45) + 1.3
        figure = new_figure(max(_CELL * columns + 1.6, 4.0), height)
        panels = figure.subplots(len(maps), 1, sharex=True, squeeze=False)[:, 0]
        for axes, (name, one) in zip(panels, maps.items(), strict=True):
            _draw(axes, one)
            axes.set_title(name, loc="left", pad=16 if axes is panels[0] else 5)
        _name_groups(panels[0], first)
        names = [shortened(place) for place in first.places]
        panels[-1].set_xticks(np.arange(columns) + 0.5, names, rotation=40, ha="right", rotation_mode="anchor")
    return figure


def map_caption(one: ResidualMap) -> str:
    """What the cells are."""
    return (
        "RMS of measured minus predicted over the noise floor of the same rows: 1 is what noise alone leaves. Grey "
        f"cells: the log has too few such rows. Channel: {one.channel}."
    )


def _draw(axes: "Axes", one: ResidualMap) -> None:
    ratio, norm = one.ratio, _norm()
    colours = require_matplotlib().colormaps[_COLOURS]
    axes.set_facecolor(_UNKNOWN)
    shown = np.ma.masked_invalid(np.clip(ratio, LEAST, MOST))
    axes.pcolormesh(shown, cmap=colours, norm=norm, edgecolors="white", linewidth=0.8)
    for (row, column), value in np.ndenumerate(ratio):
        if np.isfinite(value):
            dark = norm(np.clip(value, LEAST, MOST)) > _DARK
            ink = "white" if dark else "#1c2430"
            axes.text(column + 0.5, row + 0.5, _text(value), ha="center", va="center", fontsize=7.5, color=ink)
    axes.set_yticks(np.arange(len(one.components)) + 0.5, [shortened(name) for name in one.components])
    axes.tick_params(length=0)
    axes.grid(False)
    axes.invert_yaxis()
    for side in axes.spines.values():
        side.set_visible(False)


def _norm() -> "LogNorm":
    from matplotlib.colors import LogNorm

    return LogNorm(LEAST, MOST)


def _text(ratio: float) -> str:
    return f"{ratio:.1f}" if ratio < 9.95 else f"{ratio:.0f}" if ratio < 9999.5 else f"{ratio:.0e}"


def _name_groups(axes: "Axes", one: ResidualMap) -> None:
    """Names of the groups above their columns, with a line between neighbours."""
    groups = [
        (name, [i for i, _ in members]) for name, members in groupby(enumerate(one.groups), lambda entry: entry[1])
    ]
    for name, members in groups if len(groups) > 1 else []:
        middle = (members[0] + members[-1] + 1) / 2
        axes.annotate(
            name, (middle, 1.0), (0, 3), xycoords=("data", "axes fraction"), textcoords="offset points", ha="center",
            fontsize=8, color="#5a6472",
        )  # fmt: skip
    for panel in axes.figure.axes:
        for _, members in groups[1:]:
            panel.axvline(members[0], color="#5a6472", linewidth=1.0)
