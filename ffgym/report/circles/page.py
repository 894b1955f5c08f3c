"""The report as one HTML page that needs nothing else: no network, no scripts, no other file."""

import os
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from ffgym.core.files import check_writable, write_text
from ffgym.core.provenance import versions
from ffgym.report.circles.comparison import FACTOR, SpeedTable, circle_tables, nearness, reduction
from ffgym.report.circles.figures import circle_figures, one_axis_figures
from ffgym.report.circles.findings import PARTLY, REPRODUCED, findings
from ffgym.report.circles.headline import headline
from ffgym.report.laws import UNCOMPENSATED, baseline_of, law_styles
from ffgym.report.page import provenance_lines, render
from ffgym.studies import CircleStudy, OneAxisStudy


def write_report(
    path: str | os.PathLike[str], circle_study: CircleStudy, one_axis_study: OneAxisStudy, info: Mapping[str, Any]
) -> Path:
    """Write the report of both studies to `path`, whole or not at all.

    Args:
        path: the page, usually .html.
        circle_study: the circle test.
        one_axis_study: the sine test.
        info: more lines of provenance by name, e.g. seed and command; they replace lines of the same name. A dict
            in it, e.g. of versions, gives a line per entry.

    Returns:
        The path.

    Raises:
        FFGymError: if matplotlib or jinja2 is missing, or the file cannot be written.
    """
    target = Path(path)
    check_writable(target)  # drawing takes seconds
    write_text(target, render_report(circle_study, one_axis_study, info))
    return target


def render_report(circle_study: CircleStudy, one_axis_study: OneAxisStudy, info: Mapping[str, Any]) -> str:
    """HTML of the report; arguments as `write_report`."""
    tables = circle_tables(circle_study)
    return render(
        "report.html.j2",
        title=circle_study.title,
        one_axis_robot=one_axis_study.robot,
        styles=law_styles([*tables[0].agents, *(result.agent for result in one_axis_study.results)]),
        headline=headline(circle_study, one_axis_study),
        summary=_summary(tables),
        tables=[(table, nearness(table.ratios().values())) for table in tables],
        uncompensated=UNCOMPENSATED,
        sines=one_axis_study.results,
        findings=findings(circle_study),
        circle_figures=list(circle_figures(circle_study)),
        one_axis_figures=list(one_axis_figures(one_axis_study)),
        provenance=provenance(circle_study, one_axis_study, info),
        factor=FACTOR,
        shares={"reproduced": REPRODUCED, "partly reproduced": PARTLY},
    )


def provenance(
    circle_study: CircleStudy, one_axis_study: OneAxisStudy, info: Mapping[str, Any] | None = None
) -> dict[str, str]:
    """Where the numbers come from, by name: robots, physics, seed, versions, time, and `info`."""
    recorded = next(iter(circle_study.recordings.values())).header.provenance
    one_axis = next(iter(one_axis_study.recordings.values())).header.provenance
    return {
        "robot": circle_study.robot.name,
        "physics fingerprint": circle_study.fingerprint,
        "one-axis robot": one_axis_study.robot.name,
        "one-axis physics fingerprint": str(one_axis.get("physics_fingerprint", "unknown")),
        "seed": str(recorded.get("seed", "unknown")),
        "physics time step": f"{recorded.get('physics_dt', 'unknown')} s",
        **provenance_lines({"versions": versions()}),
        "written": datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
        **provenance_lines(info or {}),
    }


def _summary(tables: list[SpeedTable]) -> list[dict[str, Any]]:
    """One line per speed and law: mean RMS and change, simulated and published."""
    lines = []
    for table in tables:
        base = baseline_of(table.agents)
        for agent in table.agents:
            simulated, published = table.mean_rms(agent), table.mean_published_rms(agent)
            lines.append(
                {
                    "speed": table.speed_mm_s,
                    "agent": agent,
                    "simulated": simulated,
                    "published": published,
                    "change": None if agent == base else reduction(simulated, table.mean_rms(base)),
                    "published_change": None if agent == base else reduction(published, table.mean_published_rms(base)),
                }
            )
    return lines
