"""What is identified by `ffgym identify`: friction, or masses, rotors and friction, as words, numbers and a page."""

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from ffgym.cli.identify_logs import LogSet
from ffgym.cli.log_options import Identify
from ffgym.cli.progress import progress_bar
from ffgym.core.errors import check_number
from ffgym.diagnosis.identification import LowPass, friction_torque, identify_friction, validate
from ffgym.diagnosis.identification.friction import friction_quantities
from ffgym.diagnosis.identification.rigid_body import Filtering, RigidBodyOptions, identify_rigid_body, starting_robot
from ffgym.report.identification import (
    FrictionReport,
    RigidBodyReport,
    format_friction,
    format_rigid_body,
    render_friction_page,
    render_rigid_body_page,
    rigid_body_numbers,
)
from ffgym.robot import RigidArm, RobotDescription, RobotDraft
from ffgym.robot.reading.quantity import Quantity

CUTOFF_HZ = 100.0
"""Cut-off of the low-pass filter of angles and torques: it hardly rounds reversals, and takes most of the noise."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Outcome:
    """One identification; every kind of it gives one to `ffgym identify`."""

    title: str
    """Of the parameter file."""
    text: str
    """For people."""
    quantities: Mapping[str, Quantity]
    """Entries of the parameter file."""
    numbers: Mapping[str, Any]
    """Everything, as JSON has it."""
    page: Callable[[Mapping[str, Any]], str]
    """Report page, for the origin of the numbers."""


def identified_friction(config: Identify, robot: RobotDescription, logs: LogSet) -> Outcome:
    """Identify friction from logs, and see how well it holds on those kept out."""
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


def _numbers(report: FrictionReport) -> Mapping[str, Any]:
    """Everything, as JSON has it, which knows no infinity: an interval without an end is null."""
    found = report.identification
    joints = []
    for joint in found.joints:
        parameters = [asdict(estimate) for estimate in joint.estimates]
        for entry in parameters:
            low, high = entry.pop("low"), entry.pop("high")
            entry["interval"] = [low, high] if np.isfinite(high) else None
        joints.append(
            {
                "joint": joint.joint,
                "parameters": parameters,
                "inertia_error": joint.inertia_error,
                "offset": joint.offset,
                "notes": list(joint.notes),
            }
        )
    validation = [
        {
            "segment": after.segment,
            "joint": after.joint,
            "rms_friction": after.rms_friction,
            "rms_error_before": before.rms_error,
            "rms_error_after": after.rms_error,
            "share_before": before.share,
            "share_after": after.share,
        }
        for before, after in zip(report.before, report.after, strict=True)
    ]
    return {
        "logs": list(found.segments),
        "validated_on": [torque.signals.segment for torque in report.held_out],
        "level": found.level,
        "joints": joints,
        "validation": validation,
        "doubts": list(report.doubts),
    }


def identified_rigid_body(config: Identify, draft: RobotDraft, logs: LogSet) -> Outcome:
    """Identify bodies, rotors and friction from logs, and see how well they predict those kept out.

    Args:
        config: the command.
        draft: the description; where it lacks masses, they are stood in for.
        logs: recordings.
    """
    options = _options(config)
    robot = (
        starting_robot(draft, logs.used, options.filtering)
        if draft.missing
        else draft.description_for("identification")
    )
    with progress_bar("identifying", "resamples") as progress:
        fit = identify_rigid_body(robot, logs.used, options, progress)
    report = RigidBodyReport(fit=fit, held_out=logs.held_out, doubts_of_logs=logs.doubts)
    return Outcome(
        title=f"Rigid body of {robot.title}, identified",
        text=format_rigid_body(report),
        quantities=fit.quantities,
        numbers=rigid_body_numbers(report),
        page=lambda origin: render_rigid_body_page(report, logs.used[0], origin),
    )


def _options(config: Identify) -> RigidBodyOptions:
    """Options of the command; what it leaves open is the default."""
    filtering, default = Filtering(), RigidBodyOptions()
    if config.cutoff_hz is not None:
        cutoff = check_number("--cutoff-hz", config.cutoff_hz, unit="Hz", low=0.0, open_low=True)
        filtering = Filtering(parallel=LowPass(cutoff=cutoff, order=filtering.parallel.order))
    return RigidBodyOptions(
        terms=config.terms or default.terms,
        filtering=filtering,
        spread=config.spread,
        resamples=config.resamples,
        level=config.level,
        seed=config.seed,
    )
