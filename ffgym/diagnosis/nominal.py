"""A nominal model for a robot whose numbers nobody knows: rigid bodies and friction fitted to the very logs."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ffgym.diagnosis.calibration import Calibration
from ffgym.diagnosis.log.sampling import Sampling
from ffgym.errors import FFGymError
from ffgym.identification import LowPass
from ffgym.identification.rigid_body import (
    Filtering,
    RigidBodyFit,
    RigidBodyOptions,
    identify_rigid_body,
    starting_robot,
)
from ffgym.plant import Machine
from ffgym.recordings import Recording
from ffgym.robot import RobotDescription, RobotDraft

LEAST_SHARE = 0.1
"""Least standard deviation of fitted numbers, relative. An effect that is not in the model hides in its neighbours
while they are fitted (load friction in a torque constant: 24 %, parameter files of Rhoban BAM), and must be let out
again."""

RESAMPLES = 20
"""Bootstrap resamples of the fit: its standard deviations to some 15 %, which is enough where they are small."""

_NORMAL = 2.0 * 1.645
"""Width of a 90 % interval in standard deviations."""

_ORDER = 4
"""Of the low-pass that both sides of the equations go through; that of `rigid_body.Filtering`."""


def fitted_nominal(
    robot: RobotDescription | RobotDraft, recordings: Sequence[Recording]
) -> tuple[Machine, Calibration]:
    """Rigid bodies that exist, rotors and friction that predict the torque of recordings best, and how sure they are.

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
    filtering = filtering_for(robot, recordings)
    known = starting_robot(robot, recordings, filtering) if isinstance(robot, RobotDraft) else robot
    fit = identify_rigid_body(known, recordings, RigidBodyOptions(filtering=filtering, resamples=RESAMPLES))
    return Machine(robot=fit.identified), _calibration(fit)


def filtering_for(robot: RobotDescription | RobotDraft, recordings: Sequence[Recording]) -> Filtering:
    """Filters of the fit: those of the comparison, but below the resonances where joints bend.

    A rigid joint has no resonance that its description knows, so that all that is compared may be fitted.
    """
    sampling = Sampling.of(recordings[0].dt, [len(recording) for recording in recordings])
    usual = Filtering()
    bends = isinstance(robot, RobotDraft) or not robot.drive.is_rigid.all()
    cutoff = min(usual.parallel.cutoff, sampling.cutoff) if bends else sampling.cutoff
    return Filtering(motion=sampling.motion_filter, parallel=LowPass(cutoff=cutoff, order=_ORDER))


def _calibration(fit: RigidBodyFit) -> Calibration:
    """Standard deviation of the fitted friction, over all joints; bodies and rotors are as sure as that at least."""
    shares = [
        _share(fit, label)
        for label, fitted in zip(fit.labels, fit.fitted, strict=True)
        if fitted and label.startswith(("coulomb.", "viscous."))
    ]
    share = min(1.0, max(LEAST_SHARE, float(np.median(shares)) if shares else LEAST_SHARE))
    return replace(Calibration.of_share(share), base=share)


def _share(fit: RigidBodyFit, label: str) -> float:
    """Standard deviation of a parameter as a share of it."""
    k = fit.labels.index(label)
    width = float(fit.intervals.high[k] - fit.intervals.low[k])
    return width / _NORMAL / max(abs(float(fit.estimate[k])), 1e-12)
