"""Prediction of the motor torque of a recorded motion by a description: rigid inverse dynamics beside the record."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.measures import rms
from ffgym.core.types import Array, BoolArray
from ffgym.logs.preparation import LowPass, read_joint_motion, read_motor_torque
from ffgym.published import AsymmetricFriction
from ffgym.recordings import Recording
from ffgym.robot import RigidArm, RobotDescription, motor_torque

CUTOFF = 10.0
"""Cut-off of the low-pass filter [Hz]: above planned motions, below the resonances of an industrial robot."""

MOVING = 0.02
"""Joint speed [rad/s or m/s] above which a sample counts: below it the torque depends on the bristles, which no steady
law has."""

_ORDER = 4
"""Order of the Butterworth filter, which runs forward and backward, without delay."""


@dataclass(frozen=True, kw_only=True)
class TorqueError:
    """Error of a prediction of one joint's torque, motor side [N m], over the samples that move."""

    joint: str
    rms_measured: float
    rms_error: float
    max_error: float
    mean_error: float
    """Measured minus predicted."""

    @property
    def share(self) -> float:
        """RMS error over RMS torque."""
        return self.rms_error / self.rms_measured


@dataclass(frozen=True, kw_only=True, eq=False)
class TorquePrediction:
    """Measured motor torque and predictions of it."""

    robot: RobotDescription
    t: Array
    """Times [s], shape (T,)."""
    measured: Array
    """Measured torque, motor side [N m], shape (T, N)."""
    predicted: Mapping[str, Array]
    """Predictions by the name of their model; motor side [N m], shape (T, N) each."""
    scored: BoolArray
    """Samples that count, shape (T, N): the joint moves, and the ends of the record are far enough for the filter."""

    def errors(self, name: str) -> tuple[TorqueError, ...]:
        """Compute the errors of the prediction `name`, joint by joint."""
        found = []
        for j, joint in enumerate(self.robot.joints):
            measured = self.measured[self.scored[:, j], j]
            error = measured - self.predicted[name][self.scored[:, j], j]
            found.append(
                TorqueError(
                    joint=joint,
                    rms_measured=rms(measured),
                    rms_error=rms(error),
                    max_error=float(np.abs(error).max()),
                    mean_error=float(error.mean()),
                )
            )
        return tuple(found)


def predict_torque(
    robot: RobotDescription,
    recording: Recording,
    published: AsymmetricFriction | None = None,
    cutoff: float = CUTOFF,
) -> TorquePrediction:
    """Predict the motor torque of a recording from the motor angles in it.

    Predictions are `description`; with a published friction law in place of its LuGre friction, `published friction`;
    and for a robot with springs between links, the last of these `without springs`.

    Args:
        robot: description of the robot that was recorded.
        recording: the record, sampled evenly, with `motor.position` and `motor.effort`.
        published: published friction law, link side, if there is one.
        cutoff: cut-off of the zero-phase low-pass filter of the motor angles [Hz].

    Raises:
        FFGymError: if robot and recording do not fit, the recording does not state its kind of torque or is too short
            for the filter, or a joint never moves.
    """
    low_pass = LowPass(cutoff=cutoff, order=_ORDER)
    measured = read_motor_torque(robot, recording)
    q, dq, ddq = read_joint_motion(robot, recording, low_pass)
    scored = (np.abs(dq) > MOVING) & low_pass.knows(len(dq), recording.dt)[:, None]
    still = [joint for j, joint in enumerate(robot.joints) if not scored[:, j].any()]
    if still:
        raise FFGymError(
            f"Joints {still} never move faster than {MOVING} rad/s or m/s, so there is nothing to compare."
        )
    torque = motor_torque(RigidArm(robot), q, dq, ddq)
    predicted = {"description": torque.total}
    if published is not None:
        torque = replace(torque, friction=robot.drive.motor_torque(published.torque(dq)))
        predicted["published friction"] = torque.total
    if robot.springs:
        predicted["without springs"] = torque.total - torque.springs
    return TorquePrediction(robot=robot, t=recording.t, measured=measured, predicted=predicted, scored=scored)
