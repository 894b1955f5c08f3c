"""Identified friction as plain text for a terminal, at most 120 columns wide."""

from collections.abc import Sequence

import numpy as np

from ffgym.diagnosis.identification import Estimate, JointFriction
from ffgym.report.circles.tables import Column, aligned, filled
from ffgym.report.identification.friction_report import FrictionReport

LETTERS = {
    "friction.coulomb": "f_c",
    "friction.static": "f_s",
    "friction.viscous": "f_v",
    "friction.stribeck_velocity": "v_s",
    "friction.bristle_stiffness": "sigma_0",
    "friction.bristle_damping": "sigma_1",
}
"""How the thesis writes the parameters."""


def format_friction(report: FrictionReport) -> str:
    """Parameters old and new with intervals, notes, and errors on records that were not used."""
    found = report.identification
    title = f"Friction of {found.prior.title} from {len(found.segments)} logs, motor side"
    parts = [title, "-" * min(len(title), 120), _parameters(report)]
    notes = [*_reasons(found.joints), *(f"{joint.joint}: {note}" for joint in found.joints for note in joint.notes)]
    parts += [filled(f"note: {note}") for note in (*notes, *report.doubts)]
    if report.after:
        parts += ["", _validation(report)]
    return "\n".join(parts)


def _parameters(report: FrictionReport) -> str:
    rows = [estimate for joint in report.identification.joints for estimate in joint.estimates]
    columns: list[Column] = [
        ("unit", [row.unit for row in rows]),
        ("before", [f"{row.prior:.4g}" for row in rows]),
        ("now", [f"{row.value:.4g}" for row in rows]),
        (f"{report.identification.level:.0%} interval", [interval_text(row) for row in rows]),
        ("", [row.status for row in rows]),
    ]
    fixed: list[Column] = [("joint", [row.joint for row in rows]), ("parameter", [LETTERS[row.name] for row in rows])]
    return aligned(fixed, [columns])


def _reasons(joints: Sequence[JointFriction]) -> list[str]:
    """Why parameters are not identified, those of one joint and reason together."""
    reasons: dict[tuple[str, str], list[str]] = {}
    for estimate in (estimate for joint in joints for estimate in joint.estimates if estimate.reason):
        reasons.setdefault((estimate.joint, estimate.reason), []).append(LETTERS[estimate.name])
    return [f"{joint}: {', '.join(letters)}: {reason}" for (joint, reason), letters in reasons.items()]


def interval_text(estimate: Estimate) -> str:
    """Interval of an estimate; a dash where nothing is known."""
    return f"{estimate.low:.4g} to {estimate.high:.4g}" if np.isfinite(estimate.high) else "-"


def _validation(report: FrictionReport) -> str:
    legend = filled(
        "Logs that were not used: RMS of friction torque minus model [N m], and the share of the friction's variance "
        "that the model explains, before and now."
    )
    both = list(zip(report.before, report.after, strict=True))
    columns: list[Column] = [
        ("friction", [f"{new.rms_friction:.4f}" for _, new in both]),
        ("before", [f"{old.rms_error:.4f}" for old, _ in both]),
        ("now", [f"{new.rms_error:.4f}" for _, new in both]),
        ("share before", [f"{old.share:.1%}" for old, _ in both]),
        ("share now", [f"{new.share:.1%}" for _, new in both]),
    ]
    fixed: list[Column] = [("log", [new.segment for _, new in both]), ("joint", [new.joint for _, new in both])]
    return f"{legend}\n\n{aligned(fixed, [columns])}"
