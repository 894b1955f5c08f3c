"""Identified friction on a page that can be sent: parameters, curves, loops, and records that were not used."""

from collections.abc import Mapping
from datetime import UTC, datetime
from typing import Any

import numpy as np

from ffgym.report.figure import ReportFigure
from ffgym.report.identification.friction_report import FrictionReport
from ffgym.report.identification.loops_plot import friction_loops_figure
from ffgym.report.identification.stribeck_plot import stribeck_figure
from ffgym.report.identification.text import LETTERS, interval_text
from ffgym.report.page import provenance_lines, render

_MOST = 6
"""Records of a joint that are shown."""

_MOVING = 0.05
"""Motor speed from which a joint moves in a record [rad/s]."""


def render_friction_page(report: FrictionReport, info: Mapping[str, Any]) -> str:
    """HTML of the page.

    Args:
        report: what was found.
        info: provenance by name; a dict in it gives a line per entry.

    Raises:
        FFGymError: if matplotlib or jinja2 is missing.
    """
    found = report.identification
    written = {"written": datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")}
    return render(
        "identification.html.j2",
        robot=found.prior,
        identification=found,
        letters=LETTERS,
        interval=interval_text,
        validation=list(zip(report.before, report.after, strict=True)),
        doubts=list(report.doubts),
        figures=list(friction_figures(report)),
        provenance=provenance_lines(info) | written,
    )


def friction_figures(report: FrictionReport) -> list[ReportFigure]:
    """Stribeck curves of all joints, then loops of each joint with bristles, of records that were not used first."""
    found = report.identification
    figures = []
    if any(joint.stribeck is not None for joint in found.joints):
        figures.append(
            ReportFigure(
                name="stribeck",
                title="Friction at constant speed",
                thesis="Figure 6.1",
                caption="Each point is one run at constant speed. What both directions do not share is taken away.",
                figure=stribeck_figure(found),
            )
        )
    for j, joint in enumerate(found.joints):
        if joint.bristles is not None:
            figures += _loops(report, j)
    return figures


def _loops(report: FrictionReport, j: int) -> list[ReportFigure]:
    """Old against new parameters of one joint."""
    found = report.identification
    known = {"inertia_error": found.inertia_error, "offset": found.offset}
    models = {"identified": found.friction, "before": found.prior.friction}
    bristles = found.joints[j].bristles
    fitted = set() if bristles is None else set(bristles.data.segments)
    figures = []
    for name, thesis, torques, words in (
        ("fit", "Figure 6.3", report.used, "Records that were used"),
        ("validation", "Figures 6.4 to 6.7", report.held_out, "Records that were not used"),
    ):
        moving = [torque for torque in torques if _moves(torque.signals.motor_dq[torque.valid, j])]
        shown = [torque for torque in moving if name == "validation" or torque.signals.segment in fitted][:_MOST]
        if shown:
            figures.append(
                ReportFigure(
                    name=f"{name}-{j + 1}",
                    title=f"Friction of {found.joints[j].joint} over speed",
                    thesis=thesis,
                    caption=f"{words}. Inertia error and offset that were found are taken from what was measured.",
                    figure=friction_loops_figure(shown, j, models, known=known),
                )
            )
    return figures


def _moves(speed: Any) -> bool:
    return bool(len(speed) and np.abs(speed).max() > _MOVING)
