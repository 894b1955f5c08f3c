"""Supervised learning of the missing torque: run, fit to the motion that was measured, run again with the fit.

A trial shows pairs of a motor's motion and the torque that it took beyond the drive's own feed-forward. They are
labelled with the motion that was *realised*, not with the reference: before anything is learned a motor sticks where
its reference reverses, and friction is a function of its motion. A law that is fitted to these pairs is run on the
reference. Feedback error learning (`ffgym.agents.lffc`) pairs with the reference instead, and needs more trials for it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

from ffgym.agents.trials import Lesson, Trial, run_trial
from ffgym.control import CausalLaw, FeedForwardLaw, NoCompensation
from ffgym.core.errors import FFGymError, check_whole
from ffgym.core.measures import rms
from ffgym.core.types import Array, BoolArray
from ffgym.paths import Reference
from ffgym.recordings import Recording
from ffgym.robot.friction import slip_along
from ffgym.simulation import Run

NOISE_FLOOR = 1e-6
"""Smallest noise of a motion [N m]; far below what a servo resolves, and keeps the weight of a motion finite."""


@dataclass(frozen=True, kw_only=True, eq=False)
class MotorRecord:
    """Motion of the motors along one reference and its torque, at T control samples, motor side."""

    dt: float
    """Time between samples [s]."""
    motor_dq: Array
    """Realised motor speed [rad/s], shape (T, N)."""
    motor_ddq: Array
    """Motor acceleration of the reference [rad/s^2], shape (T, N); the realised one would be noise."""
    slip: Array
    """Slip elements along the realised motion, shape (T, N, W)."""
    torque: Array
    """Torque that should have been added [N m], shape (T, N)."""
    moving: BoolArray
    """False at standstill, shape (T,)."""
    noise: Array
    """Spread of the torque that is no linear function of the motor's motion [N m], shape (N,)."""
    error: Array
    """RMS of the motor position error while moving [rad], shape (N,)."""

    @classmethod
    def of(cls, reference: Reference, recording: Recording) -> "MotorRecord":
        """Read a recording of a run along `reference`.

        The torque is that of the law plus all of the feedback, less an offset: at rest the integral part carries
        the error of the gravity model at this pose, which is no property of the motors.

        Raises:
            FFGymError: if the recording lacks a column, or belongs to another reference.
        """
        # realised motion and total added torque, at the control samples
        lesson = Lesson.of(reference, recording, "u_c")
        dt = reference.robot.servo.control_dt
        rows = slice(None, None, round(dt / recording.dt))
        position = reference.motor_q - lesson.error[rows]
        motor_dq = np.gradient(position, dt, axis=0)
        slip, moving = slip_along(motor_dq, dt), lesson.moving[rows]
        total = lesson.added[rows] + lesson.signal[rows]
        # constant part and unexplained spread of the torque of each motor
        features = linear_features(slip, motor_dq, reference.motor_ddq)[moving]
        offset, noise = np.empty(total.shape[1]), np.empty(total.shape[1])
        for joint, target in enumerate(total[moving].T):
            matrix = np.column_stack([features[:, joint], np.ones(len(target))])
            solution = least_squares(matrix, target)
            offset[joint] = solution[-1]
            noise[joint] = np.std(target - matrix @ solution)
        return cls(
            dt=dt,
            motor_dq=motor_dq,
            motor_ddq=reference.motor_ddq,
            slip=slip,
            torque=total - offset,
            moving=moving,
            noise=np.maximum(noise, NOISE_FLOOR),
            error=rms(lesson.error[lesson.moving], 0),
        )


Law = TypeVar("Law", bound=CausalLaw)


@dataclass(frozen=True, kw_only=True, eq=False)
class Supervised(Generic[Law]):
    """A law that was fitted to trials, with its errors on the way; arrays of shape (trials, motions, N)."""

    law: Law
    error: Array
    """RMS of the motor position error of each trial [rad]; the first ran without the law."""
    noise: Array
    """Torque of each trial that no linear function explains [N m], see `MotorRecord`."""
    robot_seconds: float
    """Time the machine moved for it [s]."""


def learn(
    trial: Trial,
    references: Sequence[Reference],
    fit: Callable[[Sequence[MotorRecord]], Law],
    n_trials: int,
) -> Supervised[Law]:
    """Run all motions without a law and fit; run them with the fit and fit again; and so on.

    Args:
        trial: procedure that runs motions on the machine.
        references: motions to learn on.
        fit: function that makes a law from the records of the newest trial.
        n_trials: number of trials, 1 or more; the second sees motions without the sticking of the first.

    Raises:
        FFGymError: if there is no motion, or no trial.
    """
    check_whole("n_trials", n_trials, low=1)
    if not references:
        raise FFGymError("There is no motion to learn on: references is empty. Standard ones: ffgym.agents.trials.")
    law: FeedForwardLaw = NoCompensation()
    errors, noises = [], []
    for number in range(n_trials):
        recordings = run_trial(trial, [Run(reference=reference, law=law) for reference in references], number)
        records = [MotorRecord.of(*pair) for pair in zip(references, recordings, strict=True)]
        errors.append([record.error for record in records])
        noises.append([record.noise for record in records])
        law = fitted = fit(records)
    return Supervised(
        law=fitted,
        error=np.array(errors),
        noise=np.array(noises),
        robot_seconds=n_trials * sum(reference.duration for reference in references),
    )


def linear_features(slip: Array, motor_dq: Array, motor_ddq: Array) -> Array:
    """Stack the features of the linear part, (..., N, W + 2): slip elements, speed, acceleration."""
    return np.concatenate([slip, motor_dq[..., None], motor_ddq[..., None]], axis=-1)


def least_squares(matrix: Array, target: Array) -> Array:
    """Solve min |matrix x - target| for the smallest x in units of the columns; a column of zeros gets 0."""
    size = np.abs(matrix).max(axis=0)
    size[size == 0] = 1.0
    return np.asarray(np.linalg.lstsq(matrix / size, target, rcond=None)[0] / size)
