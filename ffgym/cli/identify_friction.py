"""Friction for `ffgym identify`."""

from collections.abc import Mapping
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from ffgym.cli.identify_logs import LogSet
from ffgym.cli.identify_outcome import Outcome
from ffgym.cli.progress import progress_bar
from ffgym.diagnosis.identification import LowPass, Validation, friction_torque, identify_friction, validate
from ffgym.diagnosis.identification.friction import friction_quantities
from ffgym.robot import RigidArm, RobotDescription

if TYPE_CHECKING:
    from ffgym.cli.identify import Identify

CUTOFF_HZ = 100.0
"""Cut-off of the low-pass filter of angles and torques: it hardly rounds reversals, and takes most of the noise."""


def identified_friction(config: "Identify", robot: RobotDescription, logs: LogSet) -> Outcome:
    """Identify friction from logs, and see how well it holds on those kept out."""
    from ffgym.report.identification import FrictionReport, format_friction, render_friction_page

    low_pass, arm = LowPass(cutoff=CUTOFF_HZ if config.cutoff_hz is None else config.cutoff_hz), RigidArm(robot)
    recordings = (*logs.used, *logs.held_out)
    torques = []
    with progress_bar("reading logs", "logs") as progress:
        for i, recording in enumerate(recordings):
            progress(i, len(recordings))
            torques.append(friction_torque(arm, recording, low_pass))
    used, held_out = torques[: len(logs.used)], torques[len(logs.used) :]
    velocity = config.stribeck_velocity
    with progress_bar("identifying", "joints") as progress:
        found = identify_friction(
            used,
            joints=config.joints or None,
            stribeck_velocity=None if velocity is None else dict.fromkeys(robot.joints, velocity),
            seed=config.seed,
            n_resamples=config.resamples,
            level=config.level,
            progress=progress,
        )
    known = {"inertia_error": found.inertia_error, "offset": found.offset}
    before, after = (validate(friction, held_out, **known) for friction in (robot.friction, found.friction))
    report = FrictionReport(
        identification=found, used=used, held_out=held_out, before=before, after=after, doubts=logs.doubts
    )
    return Outcome(
        title=f"LuGre friction of {robot.title}, identified",
        text=format_friction(report),
        quantities=friction_quantities(found),
        numbers=_numbers(report),
        page=lambda origin: render_friction_page(report, origin),
    )


def _numbers(report: Any) -> Mapping[str, Any]:
    found = report.identification
    joints = [
        {
            "joint": joint.joint,
            "parameters": [_finite(asdict(estimate)) for estimate in joint.estimates],
            "inertia_error": joint.inertia_error,
            "offset": joint.offset,
            "notes": list(joint.notes),
        }
        for joint in found.joints
    ]
    validation = [_both(before, after) for before, after in zip(report.before, report.after, strict=True)]
    return {
        "logs": list(found.segments),
        "validated_on": [torque.signals.segment for torque in report.held_out],
        "level": found.level,
        "joints": joints,
        "validation": validation,
        "doubts": list(report.doubts),
    }


def _finite(estimate: dict[str, Any]) -> dict[str, Any]:
    """An estimate whose interval is null where it has none: JSON knows no infinity."""
    low, high = estimate.pop("low"), estimate.pop("high")
    return estimate | {"interval": [low, high] if np.isfinite(high) else None}


def _both(before: Validation, after: Validation) -> dict[str, Any]:
    return {
        "segment": after.segment,
        "joint": after.joint,
        "rms_friction": after.rms_friction,
        "rms_error_before": before.rms_error,
        "rms_error_after": after.rms_error,
        "share_before": before.share,
        "share_after": after.share,
    }
