"""A robot check as one HTML page that needs nothing else."""

from collections.abc import Mapping
from datetime import UTC, datetime
from typing import Any

from ffgym.report.figure import ReportFigure
from ffgym.report.page import provenance_lines, render
from ffgym.report.robot.plot import robot_caption, robot_figure
from ffgym.report.robot.rendering import rendered_robot
from ffgym.report.robot.tables import robot_tables
from ffgym.report.robot.text import facts
from ffgym.studies.robot_check import RobotCheck


def render_robot_page(check: RobotCheck, info: Mapping[str, Any]) -> str:
    """HTML of the page.

    Args:
        check: what was found.
        info: provenance by name; a dict in it gives a line per entry.

    Raises:
        FFGymError: if matplotlib or jinja2 is missing.
    """
    written = {"written": datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")}
    return render(
        "robot.html.j2",
        draft=check.draft,
        facts=facts(check),
        doubts=check.doubts,
        tables=robot_tables(check),
        figures=list(robot_figures(check)),
        entries=list(check.draft.quantities.items()),
        provenance=provenance_lines(info) | written,
    )


def robot_figures(check: RobotCheck) -> list[ReportFigure]:
    """Skeleton, if the kinematics are there, and the looks, if they can be drawn."""
    figures = []
    if check.reach is not None:
        figures.append(_figure("skeleton", "Joints, masses, reach", robot_caption(check), robot_figure(check)))
    looks = rendered_robot(check)
    if looks is not None:
        figures.append(_figure("looks", "Looks", "The description's own shapes; they weigh nothing.", looks))
    return figures


def _figure(name: str, title: str, caption: str, figure: Any) -> ReportFigure:
    return ReportFigure(name=name, title=title, thesis="", caption=caption, figure=figure)
