"""What the quality gate found in logs, on a page that can be sent."""

from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from typing import Any

from ffgym.logs.quality import QualityReport
from ffgym.report.figure import ReportFigure
from ffgym.report.page import provenance_lines, render
from ffgym.report.quality.plot import limits_caption, limits_figure
from ffgym.report.quality.text import headline


def render_quality_page(reports: Sequence[tuple[str, QualityReport]], info: Mapping[str, Any]) -> str:
    """HTML of the page.

    Args:
        reports: what was found, each with the name of its log.
        info: provenance by name; a dict in it gives a line per entry.

    Raises:
        FFGymError: if matplotlib or jinja2 is missing.
    """
    logs = [
        {"name": name, "report": report, "headline": headline(report), "figure": _figure(report, place)}
        for place, (name, report) in enumerate(reports)
    ]
    written = {"written": datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")}
    return render("quality.html.j2", logs=logs, provenance=provenance_lines(info) | written)


def _figure(report: QualityReport, place: int) -> ReportFigure:
    return ReportFigure(
        name=f"limits-{place + 1}",
        title="Figures beside their limits",
        thesis="",
        caption=limits_caption(report),
        figure=limits_figure(report),
    )
