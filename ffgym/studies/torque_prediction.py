"""How well a description predicts the motor torque of a recorded motion: rigid inverse dynamics beside the record."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import butter, filtfilt

from ffgym.errors import FFGymError, check_number
from ffgym.published import AsymmetricFriction
from ffgym.recordings import Recording
from ffgym.robot import RigidArm, RobotDescription, motor_torque
from ffgym.types import Array, BoolArray

CUTOFF = 10.0
"""Cut-off of the low-pass filter [Hz]: above what planned motions hold, below the resonances of an industrial robot."""

MOVING = 0.02
"""Joint speed [rad/s or m/s] above which a sample counts: below it the bristles decide the torque, which no steady law
knows."""

_ORDER = 4
"""Order of the Butterworth filter, which runs forward and backward, so that nothing is delayed."""

_SETTLING = 3.0
"""Periods of the cut-off at either end of a record that do not count: the filter does not know what lies beyond."""

_PADDING = 3 * (_ORDER + 1)
"""Rows that the filter mirrors at either end."""


@dataclass(frozen=True, kw_only=True)
class TorqueError:
    """What a prediction leaves of one joint's torque, motor side [N m], over the samples that move."""

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
    """[s], shape (T,)."""
    measured: Array
    """Motor side [N m], shape (T, N)."""
    predicted: Mapping[str, Array]
    """By what the prediction knows; motor side [N m], shape (T, N) each."""
    scored: BoolArray
    """Samples that count, shape (T, N): the joint moves, and the ends of the record are far enough for the filter."""

    def errors(self, name: str) -> tuple[TorqueError, ...]:
        """Errors of the prediction `name`, joint by joint."""
        errors = self.measured - self.predicted[name]
        return tuple(
            _error(joint, self.measured[self.scored[:, j], j], errors[self.scored[:, j], j])
            for j, joint in enumerate(self.robot.joints)
        )


def predict_torque(
    robot: RobotDescription,
    recording: Recording,
    published: AsymmetricFriction | None = None,
    cutoff: float = CUTOFF,
) -> TorquePrediction:
    """Predict the motor torque of a recording from the motor angles in it.

    There is the prediction of the `description`; with a published friction law in place of its LuGre friction, that of
    `published friction`; and for a robot with springs between links the last of these `without springs`.

    Args:
        robot: description of the robot that was recorded.
        recording: the record, sampled evenly, with `motor.position` and `motor.effort`.
        published: a published friction law, link side; None for none.
        cutoff: cut-off of the zero-phase low-pass filter of the motor angles [Hz].

    Raises:
        FFGymError: if robot and recording do not fit, the recording does not say what its torque is or is too short
            for the filter, or a joint never moves.
    """
    measured = _measured_torque(robot, recording)
    q, dq, ddq = _joint_motion(robot, recording, cutoff)
    scored = np.abs(dq) > MOVING
    ends = round(_SETTLING / (cutoff * recording.dt))
    scored[:ends], scored[-ends:] = False, False
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


def _measured_torque(robot: RobotDescription, recording: Recording) -> Array:
    """Recorded motor torque, motor side [N m], shape (T, N)."""
    header = recording.header
    if len(header.joints) != robot.n_joints:
        raise FFGymError(
            f"The recording of {header.robot!r} has {len(header.joints)} joints, robot {robot.name!r} {robot.n_joints}."
        )
    if header.torque_semantics == "unspecified":
        raise FFGymError(f"Recording {header.segment!r} does not say what its torque is: torque_semantics.")
    torque = recording.joint_array("motor.effort")
    return robot.drive.motor_torque(torque) if header.torque_semantics == "link_side" else torque


def _joint_motion(robot: RobotDescription, recording: Recording, cutoff: float) -> tuple[Array, Array, Array]:
    """Position, speed, acceleration behind the gearbox from motor angles, without delay; SI, shape (T, N) each."""
    angle, dt = recording.joint_array("motor.position"), recording.dt
    check_number("cutoff", cutoff, unit="Hz", low=0.0, open_low=True)
    if cutoff >= 0.5 / dt or len(angle) <= _PADDING or np.ptp(np.diff(recording.t)) > 0.01 * dt:
        raise FFGymError(
            f"Recording {recording.header.segment!r} must have more than {_PADDING} rows at even times, and the "
            f"cutoff {cutoff:g} Hz must lie below {0.5 / dt:g} Hz; it has {len(angle)} rows, {dt:g} s apart."
        )
    angle = angle if recording.header.position_side == "link" else robot.drive.joint_angle(angle)
    q = filtfilt(*butter(_ORDER, cutoff, fs=1 / dt), angle, axis=0)
    dq = np.gradient(q, dt, axis=0)
    return q, dq, np.gradient(dq, dt, axis=0)


def _error(joint: str, measured: Array, error: Array) -> TorqueError:
    return TorqueError(
        joint=joint,
        rms_measured=float(np.sqrt(np.mean(measured**2))),
        rms_error=float(np.sqrt(np.mean(error**2))),
        max_error=float(np.abs(error).max()),
        mean_error=float(error.mean()),
    )
