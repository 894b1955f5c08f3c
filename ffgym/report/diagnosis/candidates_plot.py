"""Causes and their rivals: what each explains of rows that were not used."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from ffgym.diagnosis.result import Diagnosis
from ffgym.report.diagnosis.words import place_of, rivals_of
from ffgym.report.figure import house_style, legend_above, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_LOOKS: Mapping[str, Mapping[str, Any]] = {
    "cause": {"color": "#0072B2"},
    "rival that ties": {"color": "#E69F00", "hatch": "///", "edgecolor": "white", "linewidth": 0.0},
    "rival that lost": {"color": "#b9c0c9"},
}
_MOST = 6
"""Rivals of a cause that are shown, ties first, then those that explain most."""

_ROOM = 0.14
"""Room to the right of the longest bar for its figure, in bars' full length."""


def candidates_figure(diagnosis: Diagnosis) -> "Figure":
    """A bar for each cause and its strongest rivals; causes in the order of their adoption."""
    bars = _bars(diagnosis)
    with house_style():
        figure = new_figure(7.2, 0.28 * len(bars) + 1.2)
        axes = figure.subplots()
        for row, (_, gain, kind) in enumerate(bars):
            axes.barh(row, max(gain, 0.0), height=0.72, label=kind, **_LOOKS[kind])
            axes.text(max(gain, 0.0) + 0.01, row, f"{gain:.0%}", va="center", fontsize=8)
        axes.set_yticks(range(len(bars)), [name for name, _, _ in bars])
        axes.invert_yaxis()
        axes.set_xlim(0.0, max([1.0, *(gain for _, gain, _ in bars)]) + _ROOM)
        axes.grid(axis="y", visible=False)
        axes.set_xlabel("share of the residual explained on rows that were not used")
        found = dict(zip(*axes.get_legend_handles_labels()[::-1], strict=True))
        legend_above(figure, list(found.values()), list(found))
    return figure


def _bars(diagnosis: Diagnosis) -> list[tuple[str, float, str]]:
    """Name, held-out gain and kind of each bar, from top to bottom."""
    bars: list[tuple[str, float, str]] = []
    for cause in diagnosis.causes:
        bars.append((place_of(cause.effect, cause.joint), cause.held_out_gain, "cause"))
        for rival in sorted(rivals_of(diagnosis, cause)[:_MOST], key=lambda rival: -rival.held_out_gain):
            kind = "rival that ties" if rival.tied else "rival that lost"
            bars.append((place_of(rival.effect, rival.joint), rival.held_out_gain, kind))
    return bars
