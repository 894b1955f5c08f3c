"""Any motion on a page that can be sent: robot, path of the tool, errors, torques, where the numbers come from."""

from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from typing import Any

from ffgym.report.figure import ReportFigure
from ffgym.report.laws import law_styles
from ffgym.report.motion.plot import (
    motor_errors_caption,
    motor_errors_figure,
    path_error_caption,
    path_error_figure,
    torques_caption,
    torques_figure,
)
from ffgym.report.motion.tool_plot import motion_path_caption, motion_path_figure
from ffgym.report.page import provenance_lines, render
from ffgym.studies import MotionStudy


def render_motion_page(study: MotionStudy, notes: Sequence[str], info: Mapping[str, Any]) -> str:
    """HTML of the page.

    Args:
        study: what was simulated.
        notes: what the reader should know of the motion.
        info: provenance by name; a dict in it gives a line per entry.

    Raises:
        FFGymError: if matplotlib or jinja2 is missing.
    """
    motions = [
        {
            "reference": reference,
            "results": [result for result in study.results if result.motion == name],
            "figures": list(motion_figures(study, name)),
        }
        for name, reference in study.references.items()
    ]
    written = {"written": datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")}
    return render(
        "motion.html.j2",
        robot=study.robot,
        motions=motions,
        styles=law_styles(study.agents),
        notes=list(notes),
        provenance=provenance_lines(info) | written,
    )


def motion_figures(study: MotionStudy, motion: str) -> list[ReportFigure]:
    """Figures of one motion; those of the tool only where it was seen."""
    joint_figures = [
        _figure("motor-errors", "Motor errors", motor_errors_caption, motor_errors_figure, study, motion),
        _figure("torques", "Torque beside its limit", torques_caption, torques_figure, study, motion),
    ]
    if not any(result.path for result in study.results if result.motion == motion):
        return joint_figures
    return [
        _figure("path", "Path of the tool", motion_path_caption, motion_path_figure, study, motion),
        _figure("path-error", "Path error over time", path_error_caption, path_error_figure, study, motion),
        *joint_figures,
    ]


def _figure(name: str, title: str, caption: Any, figure: Any, study: MotionStudy, motion: str) -> ReportFigure:
    return ReportFigure(name=name, title=title, thesis="", caption=caption(study, motion), figure=figure(study, motion))
