"""Every figure of the quality gate over its limit, on one axis."""

from typing import TYPE_CHECKING

from ffgym.logs.quality import Finding, QualityReport
from ffgym.report.figure import house_style, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_COLOURS = {"ok": "#0072B2", "flagged": "#E69F00", "refused": "#D55E00"}
_SMALLEST, _LARGEST = 1e-3, 1e3
"""Ratios beyond are drawn at the edge: they differ by what nobody needs to see."""


def limits_figure(report: QualityReport) -> "Figure":
    """One bar for each check that was judged: its worst figure over its limit."""
    worst = _worst(report)
    with house_style():
        figure = new_figure(7.0, 0.9 + 0.19 * len(worst))
        axes = figure.subplots()
        for row, (finding, ratio) in enumerate(worst):
            axes.barh(row, ratio, left=_SMALLEST, color=_COLOURS[finding.verdict], height=0.7)
        axes.axvline(1.0, color="#444444", linewidth=1.0)
        axes.set_xscale("log")
        axes.set_xlim(_SMALLEST, 2 * _LARGEST)
        axes.set_yticks(range(len(worst)), [finding.check for finding, _ in worst])
        axes.invert_yaxis()
        axes.set_xlabel("worst figure over its limit; flagged beyond the line")
    return figure


def limits_caption(report: QualityReport) -> str:
    """What the figure shows, and what is beyond its limit."""
    beyond = dict.fromkeys(finding.check for finding in report.problems)
    listed = ", ".join(beyond) or "nothing"
    return f"Worst figure of each check over its limit, in the order of the checks. Flagged or refused: {listed}."


def _worst(report: QualityReport) -> list[tuple[Finding, float]]:
    """The finding of each check that is nearest to its limit or farthest beyond, with the ratio."""
    worst: dict[str, tuple[Finding, float]] = {}
    for finding in report.findings:
        if finding.value is None or finding.limit is None:
            continue
        ratio = finding.value / finding.limit if finding.limit > 0 else (_LARGEST if finding.value > 0 else 0.0)
        ratio = min(max(ratio, _SMALLEST), _LARGEST)
        if finding.check not in worst or ratio > worst[finding.check][1]:
            worst[finding.check] = (finding, ratio)
    order = {check: place for place, check in enumerate(worst)}
    return sorted(worst.values(), key=lambda entry: order[entry[0].check])
