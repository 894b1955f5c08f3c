"""Identified bodies, rotors and friction as plain text for a terminal, at most 120 columns wide."""

from collections.abc import Mapping

import numpy as np

from ffgym.diagnosis.identification.rigid_body import RigidBodyFit, TorqueErrors
from ffgym.report.circles.tables import Column, aligned, filled, shortened
from ffgym.report.identification.rigid_body_report import SURE, RigidBodyReport, Row, body_rows, parameter_rows


def format_rigid_body(report: RigidBodyReport) -> str:
    """What was found and who says so, and what it leaves of the torque."""
    fit = report.fit
    title = f"Rigid body of {fit.robot.title} from {len(fit.segments)} logs"
    parts = [title, "-" * min(len(title), 120), filled(_summary(fit)), ""]
    rows = parameter_rows(fit)
    if rows:
        parts += [_parameters(fit, rows), ""]
    if bodies := body_rows(fit):
        columns: list[Column] = [
            ("mass before [kg]", [f"{before:.4g}" for _, before, _, _ in bodies]),
            ("now", [f"{now:.4g}" for _, _, now, _ in bodies]),
            ("told by the data", [f"{told:.1f} of 10 numbers" for _, _, _, told in bodies]),
        ]
        parts += [aligned([("body", [shortened(name) for name, *_ in bodies])], [columns]), ""]
    if fit.not_excited:
        parts += [filled(f"note: not excited, and so as described: {', '.join(fit.not_excited)}"), ""]
    parts += [filled(f"note: {doubt}") for doubt in report.doubts]
    parts.append(_errors(fit, report.validation))
    return "\n".join(parts)


def _summary(fit: RigidBodyFit) -> str:
    """Base parameters, and how near the description."""
    told = int(np.sum(fit.base_shares >= SURE))
    text = (
        f"Torque can tell {len(fit.base.own)} combinations of {len(fit.labels)} parameters; these logs tell {told} of "
        f"them (condition number {fit.condition:.3g}). Masses and rotors are held near the description, relative "
        f"standard deviation {fit.trade_off.chosen:g}"
    )
    return text + (
        "."
        if len(fit.trade_off.spreads) == 1
        else ", the nearest that predicts held-out parts of the logs as well as any."
    )


def _parameters(fit: RigidBodyFit, rows: list[Row]) -> str:
    columns: list[Column] = [
        ("unit", [row.unit for row in rows]),
        ("before", [f"{row.before:.4g}" for row in rows]),
        ("now", [f"{row.now:.4g}" for row in rows]),
        (f"{fit.level:.0%} interval", [f"{row.low:.4g} to {row.high:.4g}" for row in rows]),
        ("told by", [row.verdict for row in rows]),
    ]
    return aligned([("parameter, motor side", [shortened(row.name) for row in rows])], [columns])


def _errors(fit: RigidBodyFit, validation: Mapping[str, TorqueErrors]) -> str:
    legend = filled(
        "RMS of the motor torque and of what is left of it [N m], over rows that move, below "
        f"{fit.filtering.parallel.cutoff:g} Hz. logs: those that were fitted; below, each that was not. file: fitted "
        "again without what a parameter file cannot hold."
    )
    rows = [(name, joint, j, e) for name, e in validation.items() for j, joint in enumerate(fit.robot.joints)]
    columns: list[Column] = [
        (kind, [f"{getattr(errors, field)[j]:.4f}" for _, _, j, errors in rows])
        for kind, field in (("torque", "measured"), ("before", "described"), ("now", "identified"), ("file", "in_file"))
    ]
    fixed: list[Column] = [
        ("log", [shortened(name) for name, *_ in rows]),
        ("joint", [shortened(joint) for _, joint, *_ in rows]),
    ]
    return f"{legend}\n\n{aligned(fixed, [columns])}"
