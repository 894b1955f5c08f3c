"""Identified friction as text for a terminal and as a page: parameters, curves, loops, and records not used."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ffgym.diagnosis.identification import Estimate, FrictionIdentification, FrictionTorque, Validation
from ffgym.diagnosis.settings import settings
from ffgym.report.figure import ReportFigure
from ffgym.report.identification.plots import friction_loops_figure, stribeck_figure
from ffgym.report.page import Note, Page, Part, Section, words_of
from ffgym.report.table import Cell, Column, Table, underline, wrap_text

LETTERS = {
    "friction.coulomb": "f_c",
    "friction.static": "f_s",
    "friction.viscous": "f_v",
    "friction.stribeck_velocity": "v_s",
    "friction.bristle_stiffness": "sigma_0",
    "friction.bristle_damping": "sigma_1",
    "friction.arm_share": "s",
}
"""Letters of the parameters in the thesis, and of the share behind the elasticity."""

_MOST = 6
"""Largest number of records of a joint that are shown."""


@dataclass(frozen=True, kw_only=True, eq=False)
class FrictionReport:
    """A friction identification with its recordings and its validation."""

    identification: FrictionIdentification
    used: Sequence[FrictionTorque]
    """Friction along the recordings that were used."""
    held_out: Sequence[FrictionTorque]
    """Friction along recordings that were not used."""
    before: Sequence[Validation]
    """Errors of the old parameters on records that were not used."""
    after: Sequence[Validation]
    """Errors of the new parameters on the same records."""
    doubts: Sequence[str] = ()
    """Doubts about logs that were used all the same."""


def format_friction(report: FrictionReport) -> str:
    """Format parameters old and new with intervals, notes, and errors on records that were not used."""
    found = report.identification
    title = f"Friction of {found.prior.title} from {len(found.segments)} logs, motor side"
    parts = [underline(title), _parameters(found, with_reasons=False).text()]
    # reasons why parameters are not identified, one line for each joint and reason
    reasons: dict[tuple[str, str], list[str]] = {}
    for estimate in (estimate for estimate in _rows(found) if estimate.reason):
        reasons.setdefault((estimate.joint, estimate.reason), []).append(LETTERS[estimate.name])
    notes = [f"{joint}: {', '.join(letters)}: {reason}" for (joint, reason), letters in reasons.items()]
    notes += [f"{joint.joint}: {note}" for joint in found.joints for note in joint.notes]
    notes += _unseen_shares(found)
    parts += [wrap_text(f"note: {note}") for note in (*notes, *report.doubts)]
    if report.after:
        legend = (
            "Logs that were not used: RMS of friction torque minus model [N m], and the share of the friction's "
            "variance that the model explains, before and now."
        )
        parts += ["", wrap_text(legend), "", _validation(report).text()]
    return "\n".join(parts)


def render_friction_page(report: FrictionReport, info: Mapping[str, Any]) -> str:
    """Render the page as HTML; `info` is its provenance by name. FFGymError if matplotlib or jinja2 is missing."""
    found = report.identification
    notes = []
    for joint in found.joints:
        notes += [f"{joint.joint}: {note}." for note in joint.notes]
        if joint.bristles is not None:
            notes.append(
                f"{joint.joint}: inertia of the model off by {joint.inertia_error:.1%}, that of the links by "
                f"{joint.link_error:+.1%} more, of the springs by {joint.spring_error:.1%}; friction "
                f"{1e3 * joint.lag:.2f} ms after the motion, torque {1e3 * joint.delay:.2f} ms after its record; "
                f"offset {joint.offset:.2g} N m; RMS of the fit {joint.bristles.rms_error:.4f} N m."
            )
    notes += [f"{note}." for note in _unseen_shares(found)]
    parts: list[Part] = [*map(Note, report.doubts)]
    parts.append(Section("Parameters", [_parameters(found, with_reasons=True), *map(Note, notes)]))
    if report.after:
        parts.append(Section("Logs that were not used", [_validation(report)]))
    return Page(
        title=f"Friction of {found.prior.title}",
        subtitle=f"LuGre parameters from {len(found.segments)} logs, motor side, with {found.level:.0%} intervals. "
        "Parameters that the logs do not excite keep their values.",
        reading=[words_of("friction")["reading"]],
        parts=[*parts, *friction_figures(report)],
        provenance=info,
    ).html()


def _rows(found: FrictionIdentification) -> list[Estimate]:
    """List the estimates of all joints; that of the share behind the elasticity where a sensor shows it."""
    return [
        estimate
        for joint in found.joints
        for estimate in (
            *joint.estimates,
            *(() if joint.arm is None or joint.arm.fit is None else (joint.arm.estimate,)),
        )
    ]


def _unseen_shares(found: FrictionIdentification) -> list[str]:
    """Tell for which joints no sensor shows the share of friction behind the elasticity, and why, once each reason."""
    reasons: dict[str, list[str]] = {}
    for joint in found.joints:
        if joint.arm is not None and joint.arm.fit is None:
            reasons.setdefault(joint.arm.estimate.reason, []).append(joint.joint)
    return [f"{', '.join(joints)}: share of friction on the arm: {reason}" for reason, joints in reasons.items()]


def _parameters(found: FrictionIdentification, *, with_reasons: bool) -> Table:
    """Tabulate parameters of all joints; reasons stand beside the verdict or, on a terminal, in notes."""
    rows = _rows(found)
    intervals = [f"{row.low:.4g} to {row.high:.4g}" if np.isfinite(row.high) else None for row in rows]
    verdicts = [f"{r.status}: {r.reason}" if with_reasons and r.reason else r.status for r in rows]
    names = [f"({row.name.removeprefix('friction.').replace('_', ' ')})" if with_reasons else "" for row in rows]
    letters = [Cell(LETTERS[row.name], name) for row, name in zip(rows, names, strict=True)]
    columns = [
        Column("joint", [row.joint for row in rows], kind="text"),
        Column("parameter", letters, kind="text"),
        Column("unit", [row.unit for row in rows], kind="text"),
        Column("before", [row.prior for row in rows], ".4g"),
        Column("now", [row.value for row in rows], ".4g"),
        Column(f"{found.level:.0%} interval", intervals),
        Column("verdict", verdicts, kind="prose" if with_reasons else "text"),
    ]
    return Table(columns=columns, name="parameters", fixed=2, ruled_by=0)


def _validation(report: FrictionReport) -> Table:
    columns = [
        Column("log", [new.segment for new in report.after], kind="text"),
        Column("joint", [new.joint for new in report.after], kind="text"),
        Column("RMS friction", [new.rms_friction for new in report.after], ".4f", unit="N m"),
        Column("error before", [old.rms_error for old in report.before], ".4f"),
        Column("now", [new.rms_error for new in report.after], ".4f"),
        Column("share before", [old.share for old in report.before], ".1%"),
        Column("share now", [new.share for new in report.after], ".1%"),
    ]
    note = "RMS of friction torque minus model, and the share of the friction's variance that the model explains."
    return Table(columns=columns, name="validation", fixed=2, note=note)


def friction_figures(report: FrictionReport) -> list[ReportFigure]:
    """Draw Stribeck curves of all joints, then loops of each joint with bristles by old and new parameters."""
    found = report.identification
    known = found.model_error
    models = {"identified": found.friction, "before": found.prior.friction}
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
        if joint.bristles is None:
            continue
        # loops of the records that were used, and of those that were not
        fitted = set(joint.bristles.data.segments)
        used = [torque for torque in report.used if torque.signals.segment in fitted]
        for name, thesis, torques, words in (
            ("fit", "Figure 6.3", used, "Records that were used"),
            ("validation", "Figures 6.4 to 6.7", report.held_out, "Records that were not used"),
        ):
            rest = settings().patterns.rest
            speeds = [np.abs(torque.signals.motor_dq[torque.valid, j]) for torque in torques]
            moving = [own for own, speed in zip(torques, speeds, strict=True) if speed.max(initial=0.0) > rest]
            if moving:
                figures.append(
                    ReportFigure(
                        name=f"{name}-{j + 1}",
                        title=f"Friction of {joint.joint} over speed",
                        thesis=thesis,
                        caption=f"{words}. Inertia error and offset that were found are taken from what was measured.",
                        figure=friction_loops_figure(moving[:_MOST], j, models, known=known),
                    )
                )
    return figures
