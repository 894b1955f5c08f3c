"""`ffgym identify`: parameters of a robot from its logs, as a file that every agent and plant accepts."""

import os
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ffgym.cli.log_options import Identify
from ffgym.cli.outputs import claim_outputs, given_options, hash_inputs, print_places, provenance, write_numbers
from ffgym.cli.progress import progress_bar
from ffgym.core.errors import FFGymError, check_number, check_whole
from ffgym.core.files import write_text
from ffgym.diagnosis.identification import Estimate, friction_torque, identify_friction, validate
from ffgym.diagnosis.identification.arm_share import ArmShare
from ffgym.diagnosis.identification.friction import friction_quantities
from ffgym.diagnosis.identification.parameter_file import parameter_text
from ffgym.diagnosis.identification.rigid_body import Filtering, RigidBodyOptions, identify_rigid_body, starting_robot
from ffgym.diagnosis.resampling import MOST_RESAMPLES
from ffgym.envs.machines import load_described_robot
from ffgym.logs import read_logs as read_motions
from ffgym.logs.preparation import LowPass
from ffgym.logs.quality import check_quality, condition_alike
from ffgym.recordings import Recording
from ffgym.recordings.io import read_folder
from ffgym.report.identification import (
    FrictionReport,
    RigidBodyReport,
    format_friction,
    format_rigid_body,
    render_friction_page,
    render_rigid_body_page,
    rigid_body_numbers,
)
from ffgym.robot import RigidArm, RobotDescription, RobotDraft, load_draft, with_parameters
from ffgym.robot.reading.quantity import Quantity

_ONLY = {"friction": ("joints", "stribeck_velocity", "stiffness_spread"), "rigid_body": ("terms", "spread")}
"""Options that only one kind of identification has."""

_NEEDS = ("position", "torque")
"""Channels that every identification takes of a log."""

LEAST_CUTOFF_HZ = 1e-3
"""Least cut-off of a filter; chosen, a period of a quarter of an hour is longer than a recording."""
CUTOFF_HZ = 100.0
"""Cut-off of the low-pass filter of angles and torques: it hardly rounds reversals, and takes most of the noise."""


def run(config: Identify) -> None:
    """Check, identify, write, print."""
    _check(config)
    if config.what == "friction":
        robot = load_described_robot(config.robot)
        outcome = identify_friction_of(config, robot, read_logs(config, robot))
    else:
        draft = load_draft(config.robot)
        robot = draft.description_for("identification")
        outcome = identify_rigid_body_of(config, draft, read_logs(config, robot, known=not draft.missing))
    info = provenance("ffgym identify", config, robot.name, None, config.seed)
    info["inputs"] = hash_inputs((*config.logs, *config.validate, config.robot, config.columns))
    # files first: printed text may go unread
    if config.out is not None:
        if not outcome.quantities:
            raise FFGymError(
                f"--out {config.out}: no parameter can be identified from these logs. Record motions that excite them; "
                "ffgym record --list says which protocol serves which parameter."
            )
        description = None
        if config.robot.endswith(".toml"):  # the user's own, which the file so finds from its folder
            relative = os.path.relpath(Path(config.robot).resolve(), config.out.resolve().parent)
            description = Path(relative).as_posix()
        write_text(config.out, parameter_text(robot, outcome.quantities, outcome.title, description))
        with_parameters(robot, config.out)
    if config.report is not None:
        write_text(config.report, outcome.page(info))
    write_numbers(config, info | dict(outcome.numbers))
    print(outcome.text)
    print_places(parameters=config.out, report=config.report, numbers=config.json)


def _check(config: Identify) -> None:
    """Refuse what cannot be run or written."""
    if not config.logs:
        raise FFGymError(
            "No logs are given. Name recordings (.npz, .csv) or folders of them: ffgym identify LOGS --robot ROBOT."
        )
    for what, names in _ONLY.items():
        if what != config.what and (given := given_options(config, names)):
            raise FFGymError(f"{', '.join(given)} has no effect on --what {config.what}. Leave it out.")
    check_whole("--resamples", config.resamples, low=2, high=MOST_RESAMPLES)
    if config.cutoff_hz is not None:
        check_number("--cutoff-hz", config.cutoff_hz, unit="Hz", low=LEAST_CUTOFF_HZ)
    check_whole("--seed", config.seed, low=0)
    check_number("--level", config.level, low=0.0, high=0.999, open_low=True)
    inputs = (config.robot, config.columns, *config.logs, *config.validate)
    places = {"--out": config.out, "--report": config.report, "--json": config.json}
    claim_outputs(places, inputs=inputs, suffix=".toml")


@dataclass(frozen=True, kw_only=True, eq=False)
class LogSet:
    """Recordings of one robot."""

    used: tuple[Recording, ...]
    """Recordings to identify from."""
    held_out: tuple[Recording, ...]
    """Recordings to validate with."""
    doubts: tuple[str, ...]
    """Objections of the quality gate to logs that are used all the same."""


def read_logs(config: Identify, robot: RobotDescription, *, known: bool = True) -> LogSet:
    """Read the recordings that a command names, or with a column map files of other tools, and condition them.

    Args:
        config: names logs to identify from, and to validate with; those that are both are for validation, and those
            that are named twice count once.
        robot: the robot that they are of.
        known: whether the description says enough for the quality gate to judge by it, masses and limits that is.

    Raises:
        FFGymError: if one cannot be read, is of another robot or not good enough, or none is left to identify from.
    """
    apart = [recording for path in config.validate for recording in _read(path, config.columns, robot)]
    named = [recording for path in config.logs for recording in _read(path, config.columns, robot)]
    given: list[Recording] = []
    for recording in named:
        if any(recording.equals(other) for other in given):
            print(f"Log {recording.header.segment!r} is given twice; it counts once.")
        elif not any(recording.equals(other) for other in apart):
            given.append(recording)
    made = condition_alike([*given, *apart])
    if not given:
        raise FFGymError("All logs are for validation, so none is left to identify from.")
    doubts = []
    with progress_bar("checking", "logs") as progress:
        for i, recording in enumerate(made):
            progress(i, len(made))
            report = check_quality(recording, robot if known else None, _NEEDS)
            if report.verdict == "insufficient":
                doubts.append(f"Log {recording.header.segment!r} is insufficient: {report.problems[0].message}")
    if doubts and not config.unchecked:
        more = f" {len(doubts) - 1} more logs have problems too." if len(doubts) > 1 else ""
        raise FFGymError(f"{doubts[0]}{more} ffgym log check LOG says all; --unchecked uses such logs all the same.")
    return LogSet(used=tuple(made[: len(given)]), held_out=tuple(made[len(given) :]), doubts=tuple(doubts))


def _read(path: Path, columns: str | None, robot: RobotDescription) -> list[Recording]:
    if columns is None and path.is_dir():
        return read_folder(path)
    return read_motions(path, columns, robot=None if columns is None else robot)


@dataclass(frozen=True, kw_only=True, eq=False)
class IdentifyOutcome:
    """One identification; every kind of it gives one to `ffgym identify`."""

    title: str
    """Title of the parameter file."""
    text: str
    """Outcome in words."""
    quantities: Mapping[str, Quantity]
    """Entries of the parameter file."""
    numbers: Mapping[str, Any]
    """Everything, as JSON has it."""
    page: Callable[[Mapping[str, Any]], str]
    """Report page, for the origin of the numbers."""


def identify_friction_of(config: Identify, robot: RobotDescription, logs: LogSet) -> IdentifyOutcome:
    """Identify friction from logs, and see how well it holds on those kept out."""
    low_pass, arm = LowPass(cutoff=CUTOFF_HZ if config.cutoff_hz is None else config.cutoff_hz), RigidArm(robot)
    # friction torque: motor torque less that of the rigid body
    recordings = (*logs.used, *logs.held_out)
    torques = []
    with progress_bar("reading logs", "logs") as progress:
        for i, recording in enumerate(recordings):
            progress(i, len(recordings))
            torques.append(friction_torque(arm, recording, low_pass))
    used, held_out = torques[: len(logs.used)], torques[len(logs.used) :]
    # LuGre parameters with intervals, from the logs that are not held out
    velocity = config.stribeck_velocity
    with progress_bar("identifying", "joints") as progress:
        found = identify_friction(
            used,
            joints=config.joints or None,
            stribeck_velocity=None if velocity is None else dict.fromkeys(robot.joints, velocity),
            stiffness_spread=config.stiffness_spread,
            seed=config.seed,
            n_resamples=config.resamples,
            level=config.level,
            progress=progress,
        )
    # validation of the description's friction and of that identified, on the held-out logs
    before, after = (validate(friction, held_out, found.model_error) for friction in (robot.friction, found.friction))
    report = FrictionReport(
        identification=found, used=used, held_out=held_out, before=before, after=after, doubts=logs.doubts
    )
    return IdentifyOutcome(
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
    # parameters of each joint; an interval without an upper end is none
    for joint in found.joints:
        parameters = [_estimate_numbers(estimate) for estimate in joint.estimates]
        joints.append(
            {
                "joint": joint.joint,
                "parameters": parameters,
                "inertia_error": joint.inertia_error,
                "link_error": joint.link_error,
                "spring_error": joint.spring_error,
                "lag_s": joint.lag,
                "delay_s": joint.delay,
                "offset": joint.offset,
                "arm_share": _arm_share_numbers(joint.arm),
                "notes": list(joint.notes),
            }
        )
    # friction error on held-out logs, before and after
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


def _estimate_numbers(estimate: Estimate) -> dict[str, Any]:
    """One parameter as JSON has it."""
    entry = asdict(estimate)
    low, high = entry.pop("low"), entry.pop("high")
    return entry | {"interval": [low, high] if np.isfinite(high) else None}


def _arm_share_numbers(arm: ArmShare | None) -> dict[str, Any] | None:
    """The share of friction behind the elasticity, and the fit behind it; None for a rigid joint."""
    if arm is None:
        return None
    fit = arm.fit
    if fit is None:
        return _estimate_numbers(arm.estimate) | {"fit": None}
    shown = {
        "share": fit.share,
        "stiffness_nm_per_rad": fit.stiffness[0],
        "stiffness_interval": fit.stiffness[1:].tolist(),
        "lost_motion_rad": fit.lost_motion,
        "spring_unloads": fit.unloads,
        "delay_s": fit.delay,
        "rms_error_rad": fit.rms_error,
        "sensor": fit.data.sensor,
    }
    return _estimate_numbers(arm.estimate) | {"fit": shown}


def identify_rigid_body_of(config: Identify, draft: RobotDraft, logs: LogSet) -> IdentifyOutcome:
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
    return IdentifyOutcome(
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
        filtering = Filtering(parallel=LowPass(cutoff=config.cutoff_hz, order=filtering.parallel.order))
    return RigidBodyOptions(
        terms=config.terms or default.terms,
        filtering=filtering,
        spread=config.spread,
        resamples=config.resamples,
        level=config.level,
        seed=config.seed,
    )
