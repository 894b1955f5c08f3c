"""Signals that identification fits to: motion and torque of a recording at the same instants, and rows that count."""

from dataclasses import dataclass, field

import numpy as np
import scipy

from ffgym.core.errors import check_class
from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.sampling import estimate_noise_above_band
from ffgym.logs.preparation import LowPass as LowPass
from ffgym.logs.preparation import read_acting_torque, read_joint_motion, read_joint_side
from ffgym.recordings import Recording
from ffgym.robot import RobotDescription


@dataclass(frozen=True, kw_only=True, eq=False)
class Signals:
    """Motion and motor torque of one recording at the same instants, T rows and N joints."""

    robot: RobotDescription
    segment: str
    """Name of the motion."""
    t: Array
    """[s], evenly spaced, shape (T,)."""
    q: Array
    """Joint positions behind the gearbox if the joints were rigid, link side [rad or m], shape (T, N)."""
    dq: Array
    """Their rate, shape (T, N)."""
    ddq: Array
    """Its rate, shape (T, N)."""
    torque: Array
    """Motor torque, motor side [N m], shape (T, N), filtered as the motion."""
    valid: BoolArray
    """Rows that the filter knows: all but the ends, shape (T,)."""
    unmasked: BoolArray
    """Rows far from all that the mask of the recording leaves out for a joint, shape (T, N)."""
    angle_noise: Array
    """Standard deviation of white noise of the measured motor angles, motor side [rad], shape (N,)."""
    low_pass: LowPass = field(default_factory=LowPass)
    """The filter that position and torque went through; a prediction of the torque goes through it too."""

    @property
    def dt(self) -> float:
        """Sample period [s]."""
        return float(self.t[-1] - self.t[0]) / (len(self.t) - 1)

    @property
    def motor_dq(self) -> Array:
        """Motor speed [rad/s], shape (T, N)."""
        return self.robot.drive.motor_angle(self.dq)

    @property
    def motor_ddq(self) -> Array:
        """Motor acceleration [rad/s^2], shape (T, N)."""
        return self.robot.drive.motor_angle(self.ddq)


def signals_of(robot: RobotDescription, recording: Recording, low_pass: LowPass | None = None) -> Signals:
    """Motion and motor torque of a recording, as its header says they are meant.

    Speed and acceleration are differences of the filtered motor angle; measured speeds are not used, since drives
    filter them with a delay. A held torque (`hold = "zoh"`) acts half a sample after its row: the mean of the two rows
    around t_i is what acts about t_i.

    Args:
        robot: the robot that was recorded.
        recording: with `motor.position` and `motor.effort`, sampled evenly.
        low_pass: filter of both; None is the thesis'.

    Raises:
        FFGymError: if robot and recording do not fit, the recording does not say what its torque is or when it acts, or
            it is sampled unevenly, too slowly or too shortly for the filter.
    """
    check_class("recording", recording, Recording, "read_recording makes one")
    low_pass = low_pass or LowPass()
    q, dq, ddq = read_joint_motion(robot, recording, low_pass)
    torque = low_pass(read_acting_torque(robot, recording), recording.dt)
    # noise above the band is that within it, as an encoder's is white
    noise = estimate_noise_above_band(read_joint_side(robot, recording), low_pass, recording.dt)
    reach = 2 * low_pass.end_rows(recording.dt) + 1
    masked = scipy.ndimage.maximum_filter1d((~recording.valid).astype(np.int8), reach, axis=0, mode="nearest")
    return Signals(
        robot=robot,
        segment=recording.header.segment,
        t=recording.t,
        q=q,
        dq=dq,
        ddq=ddq,
        torque=torque,
        valid=low_pass.knows(len(q), recording.dt),
        unmasked=masked == 0,
        angle_noise=np.abs(robot.drive.motor_angle(noise)),
        low_pass=low_pass,
    )
