"""Where the model is wrong: residual over noise floor as coloured cells."""

from collections.abc import Sequence
from itertools import groupby
from typing import TYPE_CHECKING

import numpy as np

from ffgym.diagnosis.regimes import ResidualMap
from ffgym.report.figure import house_style, new_figure, require_matplotlib
from ffgym.report.table import shortened

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LEAST, MOST = 1.0, 100.0
"""Ratios of the palest and the darkest cell; chosen: noise is pale, a hundred times as much dark."""

_COLOURS = "OrRd"
_UNKNOWN = "#e3e7ec"
"""Cells of which the log says too little."""

_CELL, _ROW = 0.5, 0.32
"""Width and height of a cell [inch]."""

_DARK = 0.55
"""Share of the colours from which figures in a cell are white."""

Panel = tuple[str, ResidualMap]
"""A map with its title."""


def map_figure(panels: Sequence[Sequence[Panel]]) -> "Figure":
    """Maps in rows of panels: the same places in those below each other, the same components in those beside."""
    first = panels[0][0][1]
    columns = len(first.places)
    heights = [_ROW * len(row[0][1].components) for row in panels]
    with house_style():
        width = len(panels[0]) * _CELL * columns + 1.2
        figure = new_figure(max(width, 5.0), sum(heights) + 0.4 * len(panels) + 1.2)
        shape = len(panels), len(panels[0])
        grid = figure.subplots(*shape, sharex="col", sharey="row", squeeze=False, height_ratios=heights)
        for row, of_row in zip(grid, panels, strict=True):
            for axes, (title, one) in zip(row, of_row, strict=True):
                _draw(axes, one)
                has_groups = axes in grid[0] and _name_groups(axes, one)
                axes.set_title(title, loc="left", pad=16 if has_groups else 5)
        for axes in grid[-1]:
            at = np.arange(columns) + 0.5
            axes.set_xticks(at, _short(first.places), rotation=40, ha="right", rotation_mode="anchor")
    return figure


def map_caption() -> str:
    """What the cells are."""
    return (
        "RMS of measured minus predicted over the noise floor: 1 is what noise alone leaves. Grey cells: the log has "
        "too few such rows, or the model claims to know nothing of them."
    )


def _draw(axes: "Axes", one: ResidualMap) -> None:
    from matplotlib.colors import LogNorm

    norm = LogNorm(LEAST, MOST)
    axes.set_facecolor(_UNKNOWN)
    shown = np.ma.masked_invalid(np.clip(one.ratio, LEAST, MOST))
    colours = require_matplotlib().colormaps[_COLOURS]
    axes.pcolormesh(shown, cmap=colours, norm=norm, edgecolors="white", linewidth=0.8)
    for (row, column), value in np.ndenumerate(one.ratio):
        if np.isfinite(value):
            ink = "white" if norm(np.clip(value, LEAST, MOST)) > _DARK else "#1c2430"
            axes.text(column + 0.5, row + 0.5, _text(value), ha="center", va="center", fontsize=7.5, color=ink)
    axes.set_yticks(np.arange(len(one.components)) + 0.5, [shortened(name) for name in one.components])
    axes.set_ylim(len(one.components), 0)
    axes.tick_params(length=0)
    axes.grid(False)
    for side in axes.spines.values():
        side.set_visible(False)
    for _, members in _groups(one)[1:]:
        axes.axvline(members[0], color="#5a6472", linewidth=1.0)


def _text(ratio: float) -> str:
    return f"{ratio:.1f}" if ratio < 9.95 else f"{ratio:.0f}" if ratio < 9999.5 else f"{ratio:.0e}"


def _groups(one: ResidualMap) -> list[tuple[str, list[int]]]:
    """Groups of places, each with its columns."""
    grouped = groupby(enumerate(one.groups), lambda entry: entry[1])
    return [(name, [i for i, _ in members]) for name, members in grouped]


def _name_groups(axes: "Axes", one: ResidualMap) -> bool:
    """Write the names of groups above their columns, if there are several."""
    groups = _groups(one)
    for name, members in groups if len(groups) > 1 else []:
        middle = (members[0] + members[-1] + 1) / 2
        axes.annotate(
            name,
            (middle, 1.0),
            (0, 3),
            xycoords=axes.get_xaxis_transform(),
            textcoords="offset points",
            ha="center",
            fontsize=8,
            color="#5a6472",
        )
    return len(groups) > 1


def _short(places: Sequence[str]) -> list[str]:
    """Names without a first part, up to a dot, that all of them have."""
    first = places[0].split(".")[0] + "."
    start = len(first) if all(place.startswith(first) for place in places) else 0
    return [shortened(place[start:]) for place in places]
