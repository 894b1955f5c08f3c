"""Maps of the residual, of the gain, and of causes and rivals that explain it."""

from collections.abc import Mapping, Sequence
from itertools import groupby
from typing import TYPE_CHECKING, Any

import numpy as np

from ffgym.diagnosis.regimes import ResidualMap, map_by_motion, map_by_regime
from ffgym.diagnosis.result import Level
from ffgym.report.diagnosis.diagnosis_report import DiagnosisReport
from ffgym.report.diagnosis.words import EXTENDED, FINE, LOOKS, NOMINAL, place_of, rivals_of, shown_share
from ffgym.report.figure import ReportFigure, panels, require_matplotlib
from ffgym.report.page import words_of
from ffgym.report.table import shorten

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


def map_figures(report: DiagnosisReport) -> list[ReportFigure]:
    """Draw maps of the residual: by regime, for torques and other channels that stand out; by motion, for all."""
    if report.before is None:
        return []
    figures, channels, models = [], report.before.channels, report.models
    cells = words_of("diagnosis_figures")["cells"]
    standing_out = {place.channel for place in report.places}
    for channel in channels:
        if channel == "torque" or (channel in standing_out and channel != "tool"):
            over = map_by_motion(report.before, channel)
            ratios = zip(over.components, over.overall, strict=True)
            whole = ", ".join(f"{component} {ratio:.1f}" for component, ratio in ratios if np.isfinite(ratio))
            figures.append(
                ReportFigure(
                    name=f"regimes-{channel}",
                    title=f"Residual over noise floor by what the joint was doing, {channel}",
                    caption=f"{cells} The whole log, nominal model: {whole}.",
                    figure=map_figure([[(name, map_by_regime(each, channel))] for name, each in models.items()]),
                )
            )
    maps = [[(f"{c}, {name}", map_by_motion(each, c)) for name, each in models.items()] for c in channels]
    figures.append(ReportFigure("motions", "Residual over noise floor by motion", cells, map_figure(maps)))
    return figures


def map_figure(maps: Sequence[Sequence[Panel]]) -> "Figure":
    """Maps in rows of panels: the same places in those below each other, the same components in those beside."""
    first = maps[0][0][1]
    columns, common = len(first.places), first.places[0].split(".")[0] + "."
    start = len(common) if all(place.startswith(common) for place in first.places) else 0  # of names, without it
    heights = [_ROW * len(row[0][1].components) for row in maps]
    size = max(len(maps[0]) * _CELL * columns + 1.2, 5.0), sum(heights) + 0.4 * len(maps) + 1.2
    sharing: dict[str, Any] = {"sharex": "col", "sharey": "row", "height_ratios": heights}
    with panels(len(maps), len(maps[0]), size=size, **sharing) as (figure, grid):
        for row, of_row in zip(grid, maps, strict=True):
            for axes, (title, one) in zip(row, of_row, strict=True):
                _draw_map(axes, one)
                has_groups = axes in grid[0] and _name_groups(axes, one)
                axes.set_title(title, loc="left", pad=16 if has_groups else 5)
        for axes in grid[-1]:
            at = np.arange(columns) + 0.5
            axes.set_xticks(
                at,
                [shorten(place[start:]) for place in first.places],
                rotation=40,
                ha="right",
                rotation_mode="anchor",
            )
    return figure


def _draw_map(axes: "Axes", one: ResidualMap) -> None:
    from matplotlib.colors import LogNorm

    norm = LogNorm(LEAST, MOST)
    axes.set_facecolor(_UNKNOWN)
    shown = np.ma.masked_invalid(np.clip(one.ratio, LEAST, MOST))
    colours = require_matplotlib().colormaps[_COLOURS]
    axes.pcolormesh(shown, cmap=colours, norm=norm, edgecolors="white", linewidth=0.8)
    for (row, column), ratio in np.ndenumerate(one.ratio):
        if np.isfinite(ratio):
            text = f"{ratio:.1f}" if ratio < 9.95 else f"{ratio:.0f}" if ratio < 9999.5 else f"{ratio:.0e}"
            ink = "white" if norm(np.clip(ratio, LEAST, MOST)) > _DARK else "#1c2430"
            axes.text(column + 0.5, row + 0.5, text, ha="center", va="center", fontsize=7.5, color=ink)
    axes.set_yticks(np.arange(len(one.components)) + 0.5, [shorten(name) for name in one.components])
    axes.set_ylim(len(one.components), 0)
    axes.tick_params(length=0)
    axes.grid(False)
    for side in axes.spines.values():
        side.set_visible(False)
    for _, members in _groups(one)[1:]:
        axes.axvline(members[0], color="#5a6472", linewidth=1.0)


def _groups(one: ResidualMap) -> list[tuple[str, list[int]]]:
    """Groups of places, each with its columns."""
    grouped = groupby(enumerate(one.groups), lambda entry: entry[1])
    return [(name, [i for i, _ in members]) for name, members in grouped]


def _name_groups(axes: "Axes", one: ResidualMap) -> bool:
    """Write the names of groups above their columns, if there are several."""
    groups = _groups(one)
    for name, members in groups if len(groups) > 1 else []:
        middle = ((members[0] + members[-1] + 1) / 2, 1.0)
        look: dict[str, Any] = {"ha": "center", "fontsize": 8, "color": "#5a6472"}
        axes.annotate(name, middle, (0, 3), xycoords=axes.get_xaxis_transform(), textcoords="offset points", **look)
    return len(groups) > 1


_MARGIN = 1.6
"""Factor of room above the largest and below the smallest value."""


def level_figures(report: DiagnosisReport) -> list[ReportFigure]:
    """RMS of each component before and after, a panel for each channel; none if nothing was compared or changed."""
    levels = report.in_joint_units.levels
    if not levels or not report.diagnosis.causes:
        return []
    channels = list(dict.fromkeys(level.channel for level in levels))
    with panels(len(channels), 1, size=(7.6, 2.0 * len(channels) + 0.6)) as (figure, grid):
        for axes, channel in zip(grid[:, 0], channels, strict=True):
            own = [level for level in levels if level.channel == channel]
            units = _draw_levels(axes, own)
            axes.set_ylabel(f"{channel} [{', '.join(units)}]")
        figure.align_ylabels()
    caption = words_of("diagnosis_figures")["levels"]
    return [ReportFigure("levels", "Residuals before and after", caption, figure)]


def _draw_levels(axes: "Axes", levels: Sequence[Level]) -> list[str]:
    """Draw levels of one channel; returns their units."""
    at = np.arange(len(levels))
    factors, units = zip(*(FINE[level.unit] for level in levels), strict=True)
    before, after, floor = (
        np.array(factors) * [getattr(level, name) for level in levels] for name in ("before", "after", "noise_floor")
    )
    axes.hlines(floor, at - 0.3, at + 0.3, color="black", linewidth=1.4, label="noise floor")
    axes.vlines(at, after, before, color="#b9c0c9", linewidth=2.0, zorder=1)
    for name, values, marker in ((NOMINAL, before, "o"), (EXTENDED, after, "D")):
        axes.plot(at, values, marker, color=LOOKS[name]["color"], markersize=7, label=name)
    axes.set_xticks(at, [shorten(level.component) for level in levels])
    axes.set_xlim(-0.6, len(levels) - 0.4)
    axes.set_yscale("log")
    known = np.concatenate([before, after, floor])
    axes.set_ylim(known.min() / _MARGIN, known.max() * _MARGIN)
    return list(dict.fromkeys(units))


_KINDS: Mapping[str, Mapping[str, Any]] = {
    "cause": {"color": "#0072B2"},
    "rival that ties": {"color": "#E69F00", "hatch": "///", "edgecolor": "white", "linewidth": 0.0},
    "rival that lost": {"color": "#b9c0c9"},
}
_MOST_RIVALS = 6
"""Rivals of a cause that are shown, ties first, then those that explain most."""

_ROOM = 0.14
"""Room to the right of the longest bar for its figure, in bars' full length."""


def candidate_figures(report: DiagnosisReport) -> list[ReportFigure]:
    """A bar for each cause and its strongest rivals, causes in the order of their adoption; none without causes."""
    diagnosis = report.diagnosis
    if not diagnosis.causes:
        return []
    bars: list[tuple[str, float, str]] = []  # name, share and kind, from top to bottom
    for cause in diagnosis.causes:
        bars.append((place_of(cause.effect, cause.joint), shown_share(cause.held_out_gain), "cause"))
        for rival in sorted(rivals_of(diagnosis, cause)[:_MOST_RIVALS], key=lambda rival: -rival.held_out_gain):
            kind = "rival that ties" if rival.tied else "rival that lost"
            bars.append((place_of(rival.effect, rival.joint), shown_share(rival.held_out_gain), kind))
    with panels(size=(7.2, 0.28 * len(bars) + 1.2)) as (figure, grid):
        axes = grid[0, 0]
        for row, (_, gain, kind) in enumerate(bars):
            axes.barh(row, gain, height=0.72, label=kind, **_KINDS[kind])
            axes.text(gain + 0.01, row, f"{gain:.0%}", va="center", fontsize=8)
        axes.set_yticks(range(len(bars)), [name for name, _, _ in bars])
        axes.invert_yaxis()
        axes.set_xlim(0.0, 1.0 + _ROOM)
        axes.grid(axis="y", visible=False)
        axes.set_xlabel("share of the residual above the noise that is explained")
    caption = words_of("diagnosis_figures")["candidates"].format(threshold=diagnosis.threshold)
    return [ReportFigure("candidates", "Causes and rivals", caption, figure)]
