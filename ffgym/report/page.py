"""The report as one HTML page that needs nothing else: no network, no scripts, no other file."""

import base64
import os
from collections.abc import Mapping
from datetime import UTC, datetime
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ffgym.errors import FFGymError
from ffgym.files import check_writable, write_text
from ffgym.provenance import versions
from ffgym.report._matplotlib import encode_figure, require_matplotlib
from ffgym.report.comparison import FACTOR, SpeedTable, circle_tables, nearness, percent, reduction
from ffgym.report.figures import ReportFigure, circle_figures, one_axis_figures
from ffgym.report.findings import PARTLY, REPRODUCED, findings
from ffgym.report.headline import headline
from ffgym.report.laws import UNCOMPENSATED, baseline_of, law_styles
from ffgym.studies import CircleStudy, OneAxisStudy

if TYPE_CHECKING:
    from jinja2 import Environment


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
    require_matplotlib()
    template = _environment().get_template("report.html.j2")
    tables = circle_tables(circle_study)
    return template.render(
        robot=circle_study.robot,
        one_axis_robot=one_axis_study.robot,
        styles=law_styles([*tables[0].agents, *(result.agent for result in one_axis_study.results)]),
        headline=headline(circle_study, one_axis_study),
        summary=_summary(tables),
        tables=[(table, nearness(table.ratios().values())) for table in tables],
        uncompensated=UNCOMPENSATED,
        sines=one_axis_study.results,
        findings=findings(circle_study),
        circle_figures=[_embedded(figure) for figure in circle_figures(circle_study)],
        one_axis_figures=[_embedded(figure) for figure in one_axis_figures(one_axis_study)],
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
        **_lines({"versions": versions()}),
        "written": datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
        **_lines(info or {}),
    }


def _lines(info: Mapping[str, Any]) -> dict[str, str]:
    """Names and values as text; the entries of a dict become lines, those of a list stand in one."""
    lines: dict[str, str] = {}
    for name, value in info.items():
        if isinstance(value, Mapping):
            lines |= _lines(value)
        elif isinstance(value, list | tuple):
            lines[name.replace("_", " ")] = ", ".join(str(entry) for entry in value) or "none"
        else:
            lines[name.replace("_", " ")] = "none" if value is None else str(value)
    return lines


def _environment() -> "Environment":
    try:
        from jinja2 import Environment, FunctionLoader, StrictUndefined
    except ImportError as error:
        raise FFGymError("The report page needs jinja2; pip install 'ffgym[report]'.") from error
    environment = Environment(
        loader=FunctionLoader(_template),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["change"] = lambda share: "–" if share is None else percent(share)
    environment.filters["mm"] = lambda value, digits=3: "–" if value is None else f"{value:.{digits}f}"
    return environment


def _template(name: str) -> str:
    return (resources.files("ffgym.report") / "templates" / name).read_text(encoding="utf-8")


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


def _embedded(figure: ReportFigure) -> dict[str, Any]:
    """A figure as the template takes it: its picture inside the page."""
    picture = base64.b64encode(encode_figure(figure.figure, "svg")).decode()
    return {
        "name": figure.name,
        "title": figure.title,
        "thesis": figure.thesis,
        "caption": figure.caption,
        "width": round(figure.figure.get_figwidth() * 96),
        "source": f"data:image/svg+xml;base64,{picture}",
    }
