"""Findings of the quality gate as text for a terminal and as a page that can be sent."""

from collections.abc import Mapping, Sequence
from typing import Any

from ffgym.logs.quality import Finding, QualityReport
from ffgym.report.figure import ReportFigure, panels
from ffgym.report.page import Details, Page, Part, Section, words_of
from ffgym.report.table import Cell, Column, Table, wrap_text

_WORDS = {
    "good": "good: every check that could be judged passed",
    "usable": "usable, with the flagged checks in mind",
    "insufficient": "insufficient: conclusions that need a refused check are not valid",
}
_COLOURS = {"ok": "#0072B2", "flagged": "#E69F00", "refused": "#D55E00"}
_SMALLEST, _LARGEST = 1e-3, 1e3
"""Ratios beyond are drawn at the edge: their differences do not matter."""


def format_quality(report: QualityReport, *, figures: bool = False) -> str:
    """Format verdict, number of checks not judged, conditioning, and every problem, once for several joints.

    With `figures` also every figure beside its limit, and the checks that were not judged.
    """
    unknown = dict.fromkeys(finding.check for finding in report.findings if finding.verdict == "not judged")
    lines = [_verdict(report) + (f" {len(unknown)} checks not judged." if unknown else "")]
    lines += [wrap_text(f"conditioned: {note}") for note in report.conditioning]
    problems = [f"{finding.verdict}: [{finding.check}] {finding.message}" for finding in report.problems]
    lines += [wrap_text(problem) for problem in dict.fromkeys(problems)]
    if figures:
        lines.append(_figures([finding for finding in report.findings if finding.value is not None]).text())
        lines += [wrap_text(f"not judged: {', '.join(unknown)}")] if unknown else []
    return "\n".join(lines)


def render_quality_page(reports: Sequence[tuple[str, QualityReport]], info: Mapping[str, Any]) -> str:
    """Render the page on reports as HTML, each with the name of its log; `info` is its provenance by name.

    FFGymError if matplotlib or jinja2 is missing.
    """
    return Page(
        title="Quality of logs",
        subtitle="Verdict on each log, and every figure beside its limit. Reasons for the limits: docs/quality.md",
        reading=[words_of("quality")["reading"]],
        headline=[_summary([report for _, report in reports])],
        parts=[
            _overview(reports),
            *(_section(name, report, place) for place, (name, report) in enumerate(reports, 1)),
        ],
        provenance=info,
    ).html()


def _summary(reports: Sequence[QualityReport]) -> str:
    """Count the logs of each verdict."""
    verdicts = [report.verdict for report in reports]
    counts = [f"{verdicts.count(verdict)} **{verdict}**" for verdict in _WORDS if verdict in verdicts]
    return f"{len(reports)} log{'s' * (len(reports) != 1)}: {', '.join(counts)}."


def _overview(reports: Sequence[tuple[str, QualityReport]]) -> Table:
    """Tabulate the logs with their verdicts and the checks that are refused or flagged."""
    checks = {
        word: [", ".join(dict.fromkeys(f.check for f in report.problems if f.verdict == word)) for _, report in reports]
        for word in ("refused", "flagged")
    }
    styles = {"insufficient": "refused", "usable": "flagged"}
    verdicts = [Cell(report.verdict, style=styles.get(report.verdict, "")) for _, report in reports]
    columns = [
        Column("log", [name for name, _ in reports], kind="text"),
        Column("motion", [report.segment for _, report in reports], kind="text"),
        Column("duration", [report.duration for _, report in reports], ".4g", unit="s"),
        Column("verdict", verdicts, kind="text"),
        *(Column(word, [names or None for names in own], kind="prose") for word, own in checks.items()),
    ]
    return Table(columns=columns, name="logs")


def _section(name: str, report: QualityReport, place: int) -> Section:
    """Lay out the findings in one log."""
    problems = Table(
        columns=[
            Column("verdict", [Cell(found.verdict, style=found.verdict) for found in report.problems], kind="text"),
            Column("check", [found.check for found in report.problems], kind="code"),
            Column("what was seen", [found.message for found in report.problems], kind="prose"),
        ]
    )
    figures: list[Part] = [_limits(report, place), _figures(report.findings, with_verdict=True)]
    parts: list[Part] = [f"Conditioned: {note}" for note in report.conditioning]
    if report.problems:
        parts += [problems, figures.pop(0)]
    parts.append(Details("Every figure", figures))
    return Section(name, parts, headline=[_verdict(report)])


def _verdict(report: QualityReport) -> str:
    """Write the verdict in one sentence."""
    name = f"{report.robot}, {report.segment}" if report.segment else report.robot
    return f"{name}: {report.n_rows} rows, {report.duration:.6g} s. {_WORDS[report.verdict].capitalize()}."


def _figures(findings: Sequence[Finding], *, with_verdict: bool = False) -> Table:
    """Tabulate every figure beside its limit."""
    columns = [
        Column("check", [found.check for found in findings], kind="code"),
        Column("of", [found.place for found in findings], kind="text"),
        Column("figure", ["" if found.value is None else found.value for found in findings], ".4g"),
        Column("limit", ["" if found.limit is None else found.limit for found in findings], ".4g"),
        Column("unit", [found.unit for found in findings], kind="text"),
    ]
    if with_verdict:
        verdicts = []
        for found in findings:
            why = ": " + found.message.replace("Not judged: ", "") if found.verdict == "not judged" else ""
            verdicts.append(Cell(found.verdict + why, style=found.verdict))
        columns.append(Column("verdict", verdicts, kind="text"))
    return Table(columns=columns)


def _limits(report: QualityReport, place: int) -> ReportFigure:
    """Draw one bar for each check that was judged: its worst figure over its limit."""
    worst: dict[str, tuple[float, str]] = {}  # ratio and verdict by check
    for finding in report.findings:
        if finding.value is None or finding.limit is None:
            continue
        ratio = finding.value / finding.limit if finding.limit > 0 else (_LARGEST if finding.value > 0 else 0.0)
        ratio = min(max(ratio, _SMALLEST), _LARGEST)
        if finding.check not in worst or ratio > worst[finding.check][0]:
            worst[finding.check] = (ratio, finding.verdict)
    with panels(size=(7.0, 1.2 + 0.19 * len(worst))) as (figure, grid):
        axes = grid[0, 0]
        for row, (ratio, verdict) in enumerate(worst.values()):
            axes.barh(row, ratio, left=_SMALLEST, color=_COLOURS[verdict], height=0.7, label=verdict)
        axes.axvline(1.0, color="#444444", linewidth=1.0)
        axes.set_xscale("log")
        axes.set_xlim(_SMALLEST, 2 * _LARGEST)
        axes.set_yticks(range(len(worst)), list(worst))
        axes.set_ylim(len(worst) - 0.3, -0.7)
        axes.set_xlabel("worst figure over its limit; flagged beyond the line")
    beyond = ", ".join(dict.fromkeys(finding.check for finding in report.problems)) or "nothing"
    return ReportFigure(
        name=f"limits-{place}",
        title="Figures beside their limits",
        caption=f"Worst figure of each check over its limit, in the order of the checks. Flagged or refused: {beyond}.",
        figure=figure,
    )
