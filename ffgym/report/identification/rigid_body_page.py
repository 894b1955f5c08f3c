"""An identified rigid body on a page that can be sent: combinations, parameters, and torque that was not fitted."""

from collections.abc import Mapping
from datetime import UTC, datetime
from typing import Any

import numpy as np

from ffgym.recordings import Recording
from ffgym.report.figure import ReportFigure
from ffgym.report.identification.rigid_body_report import SURE, RigidBodyReport, base_rows, body_rows, parameter_rows
from ffgym.report.page import provenance_lines, render
from ffgym.report.robot.torque_plot import torque_figure
from ffgym.studies.torque_prediction import TorquePrediction

_MOST = 4
"""Recordings that are shown."""


def render_rigid_body_page(report: RigidBodyReport, used: Recording, info: Mapping[str, Any]) -> str:
    """HTML of the page.

    Args:
        report: what was found.
        used: a recording that was fitted, which is shown where none was kept out.
        info: provenance by name; a dict in it gives a line per entry.

    Raises:
        FFGymError: if matplotlib or jinja2 is missing.
    """
    fit = report.fit
    written = {"written": datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")}
    shown = list(report.held_out[:_MOST]) or [used]
    words = "not fitted" if report.held_out else "fitted"
    return render(
        "rigid_body.html.j2",
        fit=fit,
        told=int(np.sum(fit.base_shares >= SURE)),
        parameters=parameter_rows(fit),
        bodies=body_rows(fit),
        combinations=base_rows(fit),
        validation=report.validation,
        doubts=list(report.doubts),
        figures=[_figure(report, recording, words) for recording in shown],
        provenance=provenance_lines(info) | written,
    )


def _figure(report: RigidBodyReport, recording: Recording, words: str) -> ReportFigure:
    """Measured and predicted torque of a recording."""
    segment = recording.header.segment
    return ReportFigure(
        name=f"torque-{segment}",
        title=f"Motor torque of {segment}",
        thesis="",
        caption=f"This recording was {words}. Torque and predictions are filtered alike.",
        figure=torque_figure(prediction_of(report, recording)),
    )


def prediction_of(report: RigidBodyReport, recording: Recording) -> TorquePrediction:
    """Filtered torque of a recording, and what the description and the fit make of its motion."""
    fit = report.fit
    equations = fit.equations([recording])
    residuals = {"description": fit.described, "identified": fit.estimate}
    return TorquePrediction(
        robot=fit.robot,
        t=equations.t,
        measured=equations.measured,
        predicted={name: equations.measured - equations.residual(values) for name, values in residuals.items()},
        scored=equations.counts,
    )
