"""Nominal models: rigid bodies and friction fitted to the diagnosed logs, and the model of the example logs."""

from collections.abc import Sequence
from dataclasses import replace
from importlib import resources
from pathlib import Path

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.diagnosis.identification.rigid_body import (
    Filtering,
    RigidBodyFit,
    RigidBodyOptions,
    identify_rigid_body,
    starting_robot,
)
from ffgym.diagnosis.nuisance import ParameterPrior
from ffgym.diagnosis.sampling import Sampling
from ffgym.diagnosis.settings import settings
from ffgym.logs.preparation import LowPass
from ffgym.recordings import Recording
from ffgym.recordings.npz import decode
from ffgym.robot import RobotDescription, RobotDraft
from ffgym.robot.template.proposals import PRESLIDING
from ffgym.simulation.plant import Machine

_NORMAL = 2.0 * 1.645
"""Width of a 90 % interval in standard deviations."""

_ORDER = 4
"""Order of the low-pass that both sides of the equations go through; that of `rigid_body.Filtering`."""


def fit_nominal(
    robot: RobotDescription | RobotDraft, recordings: Sequence[Recording]
) -> tuple[Machine, ParameterPrior]:
    """Fit rigid bodies that can exist, rotors and friction to the torque of recordings, with their priors.

    What an effect does to torque at all times, as more friction or a torque offset, such a model has already: it is in
    its numbers, and cannot be a cause. What depends on anything else is left, and is what a diagnosis can find.

    Args:
        robot: geometry, gears and gravity, and what else is known of it.
        recordings: that are to be diagnosed.

    Raises:
        FFGymError: if recordings do not fit the robot, or do not tell its numbers.
    """
    if not recordings:
        raise FFGymError("There is nothing to fit a nominal model to: no recordings.")
    filtering = choose_filtering(robot, recordings)
    known = starting_robot(robot, recordings, filtering) if isinstance(robot, RobotDraft) else robot
    fit = identify_rigid_body(
        known, recordings, RigidBodyOptions(filtering=filtering, resamples=settings().prior.fit_resamples)
    )
    quick = RigidBodyOptions(filtering=filtering, resamples=2, spread=fit.trade_off.chosen)

    def refit(left: Sequence[Recording]) -> RobotDescription:
        return _complete(robot, identify_rigid_body(known, left, quick).identified)

    return Machine(robot=_complete(robot, fit.identified)), replace(_derive_prior(fit), refit=refit)


def _complete(robot: RobotDescription | RobotDraft, found: RobotDescription) -> RobotDescription:
    """Complete a fitted robot: where presliding is unknown, bristles bend no further than those of a usual joint."""
    if not isinstance(robot, RobotDraft) or "friction.bristle_stiffness" in robot.quantities:
        return found
    # gear ratios that are written as 1, as torque and angles are those of the joints, make no motor of it
    travel = np.minimum(PRESLIDING, settings().prior.joint_presliding * np.abs(found.drive.gear_ratio))
    stiffness, damping = found.friction.coulomb / travel, np.zeros_like(travel)
    return replace(found, friction=replace(found.friction, bristle_stiffness=stiffness, bristle_damping=damping))


def choose_filtering(robot: RobotDescription | RobotDraft, recordings: Sequence[Recording]) -> Filtering:
    """Choose filters of the fit: those of the comparison, but below the resonances where joints bend.

    A rigid joint has no resonance that its description knows, so that all that is compared may be fitted.
    """
    sampling = Sampling.of(recordings[0].dt, [len(recording) for recording in recordings])
    usual = Filtering()
    bends = isinstance(robot, RobotDraft) or not robot.drive.is_rigid.all()
    cutoff = min(usual.parallel.cutoff, sampling.cutoff) if bends else sampling.cutoff
    return Filtering(motion=sampling.motion_filter, parallel=LowPass(cutoff=cutoff, order=_ORDER))


def _derive_prior(fit: RigidBodyFit) -> ParameterPrior:
    """Derive the prior from intervals of the fitted friction; bodies and rotors are known at least as well."""
    limits = settings().prior
    widths, estimates = fit.intervals.high - fit.intervals.low, np.maximum(np.abs(fit.estimate), 1e-12)
    shares = [
        float(width) / _NORMAL / float(size)
        for label, fitted, width, size in zip(fit.labels, fit.fitted, widths, estimates, strict=True)
        if fitted and label.startswith(("coulomb.", "viscous."))
    ]
    # the share by which fitted friction is unsure, never less than an exact fit can claim
    share = min(1.0, max(limits.fitted_share, float(np.median(shares)) if shares else limits.fitted_share))
    return ParameterPrior(
        share=share,
        levels=limits.fitted_friction,
        torque_constant=limits.torque_constant,
        offset=limits.fitted_offset,
        base=share,
    )


EXAMPLE_ROBOT = "irb4600_60_205"
"""Nominal model of the machine that the logs are of."""


EXAMPLE_LOGS = Path(str(resources.files("ffgym.diagnosis"))) / "data"
"""Folder of the example logs."""


def example_logs() -> list[Recording]:
    """The first recording of a machine that its model describes but for two faults, in the order of the session.

    `scripts/example_logs.py` makes them, on a machine of the workcell's kind.
    """
    logs = [decode(file.read_bytes()) for file in EXAMPLE_LOGS.iterdir() if file.suffix == ".npz"]
    return sorted(logs, key=lambda log: float(log.header.meta["session_start"]))
