"""What identification sees of a recording: motion and torque at even times, filtered without delay, sides in order."""

from dataclasses import dataclass, field

import numpy as np
import scipy

from ffgym.core.errors import FFGymError, check_number, check_whole
from ffgym.core.types import Array, BoolArray
from ffgym.logs.quality.signals import is_even
from ffgym.recordings import Recording
from ffgym.robot import RobotDescription

_SAME_RATIO = 1e-6
"""Relative difference of gear ratios above which a recording is of another drive: ratios are written with 6 digits."""


@dataclass(frozen=True, kw_only=True)
class LowPass:
    """Butterworth low-pass that runs forward and backward, so that nothing is delayed."""

    cutoff: float = 40.0
    """Where each of both runs has lost 3 dB [Hz]; the default is that of thesis 6.1.2."""
    order: int = 2
    """Of each run; the default is that of thesis 6.1.2."""
    settling: float = 3.0
    """Periods of the cut-off at either end of a record that do not count: the filter does not know what lies beyond."""

    def __post_init__(self) -> None:
        check_number("cutoff", self.cutoff, unit="Hz", low=0.0, open_low=True)
        check_whole("filter order", self.order, low=1, high=8)
        check_number("settling", self.settling, unit="periods", low=0.0)

    @property
    def padding(self) -> int:
        """Rows that the filter mirrors at either end."""
        return 3 * (self.order + 1)

    def end_rows(self, dt: float) -> int:
        """Rows at either end of a record, sampled every `dt` [s], that do not count."""
        return round(self.settling / (self.cutoff * dt))

    def knows(self, n_rows: int, dt: float) -> BoolArray:
        """Rows of a record that count: all but its ends, shape (n_rows,)."""
        rows, ends = np.arange(n_rows), self.end_rows(dt)
        return np.asarray((rows >= ends) & (rows < n_rows - ends))

    def __call__(self, values: Array, dt: float) -> Array:
        """Filter `values` (T, ...), sampled every `dt` [s], along time."""
        if self.cutoff >= 0.5 / dt or len(values) <= self.padding:
            raise FFGymError(
                f"The low-pass at {self.cutoff:g} Hz must lie below {0.5 / dt:g} Hz, half the sample rate, and takes "
                f"more than {self.padding} rows; there are {len(values)}, {dt:g} s apart."
            )
        coefficients = scipy.signal.butter(self.order, self.cutoff, fs=1 / dt)
        return np.asarray(scipy.signal.filtfilt(*coefficients, values, axis=0))


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
    low_pass = low_pass or LowPass()
    q, dq, ddq = joint_motion(robot, recording, low_pass)
    torque = low_pass(acting_torque(robot, recording), recording.dt)
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
        low_pass=low_pass,
    )


def joint_motion(robot: RobotDescription, recording: Recording, low_pass: LowPass) -> tuple[Array, Array, Array]:
    """Position, speed, acceleration behind the gearbox from motor angles, without delay; SI, shape (T, N) each."""
    check_fits(robot, recording)
    angle, dt = recording.joint_array("motor.position"), recording.dt
    if not is_even(recording.t):
        raise FFGymError(
            f"Recording {recording.header.segment!r} is sampled unevenly, every {np.diff(recording.t).min():g} to "
            f"{np.diff(recording.t).max():g} s; ffgym.logs.conditioned brings it to even times."
        )
    angle = angle if recording.header.position_side == "link" else robot.drive.joint_angle(angle)
    q = low_pass(angle, dt)
    dq = np.gradient(q, dt, axis=0)
    return q, dq, np.gradient(dq, dt, axis=0)


def motor_effort(robot: RobotDescription, recording: Recording) -> Array:
    """Recorded motor torque, motor side [N m], shape (T, N), row by row as it stands in the recording."""
    check_fits(robot, recording)
    header = recording.header
    if header.torque_semantics == "unspecified":
        raise FFGymError(f"Recording {header.segment!r} does not say what its torque is: torque_semantics.")
    torque = recording.joint_array("motor.effort")
    return robot.drive.motor_torque(torque) if header.torque_semantics == "link_side" else torque


def acting_torque(robot: RobotDescription, recording: Recording) -> Array:
    """Motor torque that acts about the time of each row, motor side [N m], shape (T, N)."""
    torque, hold = motor_effort(robot, recording), recording.header.hold
    if hold == "unspecified":
        raise FFGymError(
            f"Recording {recording.header.segment!r} does not say when its torque acts, and half a sample matters: set "
            f"hold in its header to zoh, linear or sampled, see docs/recordings.md."
        )
    if hold == "zoh":
        return np.concatenate([torque[:1], 0.5 * (torque[:-1] + torque[1:])])
    return torque


def check_fits(robot: RobotDescription, recording: Recording) -> None:
    """Raise FFGymError if a recording cannot be of a robot, as it has other joints or gear ratios."""
    header = recording.header
    if len(header.joints) != robot.n_joints:
        raise FFGymError(
            f"The recording of {header.robot!r} has {len(header.joints)} joints, robot {robot.name!r} {robot.n_joints}."
        )
    if not np.allclose(header.gear_ratio, robot.drive.gear_ratio, rtol=_SAME_RATIO, atol=0.0):
        raise FFGymError(
            f"The recording {header.segment!r} of {header.robot!r} has gear ratios {list(header.gear_ratio)}, robot "
            f"{robot.name!r} {robot.drive.gear_ratio.tolist()}: one of them is wrong."
        )
