"""Recordings made ready: motion and torque on the side that a computation takes, at even times, without delay.

What the header of a recording says of sides, torque and when it acts is read here, for the quality gate, identification
and diagnosis alike; so are the low-pass and the derivatives of all of them.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from ffgym.core.errors import FFGymError, check_number, check_whole
from ffgym.core.types import Array, BoolArray
from ffgym.logs.quality.signals import is_even
from ffgym.recordings import Header, Recording
from ffgym.robot import RobotDescription
from ffgym.robot.drive import Drive

_SAME_RATIO = 1e-6
"""Relative difference of gear ratios above which a recording is of another drive: ratios are written with 6 digits."""


@dataclass(frozen=True, kw_only=True)
class LowPass:
    """Butterworth low-pass that runs forward and backward, so that nothing is delayed."""

    cutoff: float = 40.0
    """Frequency at which each run has lost 3 dB [Hz]; the default is that of thesis 6.1.2."""
    order: int = 2
    """Order of each run; the default is that of thesis 6.1.2."""
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
        """Number of rows at either end of a record, sampled every `dt` [s], that do not count."""
        return round(self.settling / (self.cutoff * dt))

    def knows(self, n_rows: int, dt: float) -> BoolArray:
        """Rows of a record that count: all but its ends, shape (n_rows,)."""
        rows, ends = np.arange(n_rows), self.end_rows(dt)
        return np.asarray((rows >= ends) & (rows < n_rows - ends))

    def gain(self, frequency: Array, dt: float) -> Array:
        """Share of signals of some frequencies [Hz], samples `dt` [s] apart, that passes both runs."""
        ratio = np.tan(np.pi * dt * frequency) / np.tan(np.pi * dt * self.cutoff)
        passed: Array = 1 / (1 + ratio ** (2 * self.order))
        return passed

    def __call__(self, values: Array, dt: float) -> Array:
        """Filter `values` (T, ...), sampled every `dt` [s], along time."""
        if self.cutoff >= 0.5 / dt or len(values) <= self.padding:
            raise FFGymError(
                f"The low-pass at {self.cutoff:g} Hz must lie below {0.5 / dt:g} Hz, half the sample rate, and takes "
                f"more than {self.padding} rows; there are {len(values)}, {dt:g} s apart."
            )
        coefficients = scipy.signal.butter(self.order, self.cutoff, fs=1 / dt)
        return np.asarray(scipy.signal.filtfilt(*coefficients, values, axis=0))


def differentiate(angle: Array, dt: float) -> tuple[Array, Array]:
    """Compute the first and second derivative of samples (T, ...) along time, T > 2.

    Those of the sine series through the samples, less their chord: a motion that rests at both ends goes on smoothly
    beyond them. Differences of neighbours lose 1 - (sin x / x)^2 of an acceleration, x = 2 pi f dt: a third of it at a
    tenth of the sample rate twice over, which would be seen as a wrong inertia. What is above the band of the motion is
    not damped here; low-pass before.
    """
    n = len(angle) - 1
    chord = (angle[-1] - angle[0]) / n
    k = np.arange(n + 1).reshape(-1, *(1,) * (angle.ndim - 1))
    inner = (angle - angle[0] - chord * k)[1:-1]
    frequency = np.pi * k[1:-1] / (n * dt)
    series = scipy.fft.dst(inner, type=1, axis=0) / n
    rate = np.zeros_like(angle)
    rate[1:-1] = frequency * series
    change = np.zeros_like(angle)
    change[1:-1] = scipy.fft.dst(-(frequency**2) * series, type=1, axis=0) / 2
    first: Array = scipy.fft.dct(rate, type=1, axis=0) / 2 + chord / dt
    return first, change


def differentiate_motions(angle: Array, lengths: Sequence[int], dt: float) -> tuple[Array, Array]:
    """Compute derivatives of motions side by side (T, M, ...), each of its own length; 0 in what is padded."""
    first, second = np.zeros_like(angle), np.zeros_like(angle)
    for i, n in enumerate(lengths):
        first[:n, i], second[:n, i] = differentiate(angle[:n, i], dt)
    return first, second


def convert_to_joint_side(drive: Drive, header: Header, values: Array) -> Array:
    """Bring positions, speeds or accelerations (T, N) of a recording behind the gearbox."""
    return values if header.position_side == "link" else drive.joint_angle(values)


def read_joint_side(robot: RobotDescription, recording: Recording, family: str = "motor.position") -> Array:
    """Read measured or set positions, speeds or accelerations behind the gearbox, shape (T, N)."""
    return convert_to_joint_side(robot.drive, recording.header, recording.joint_array(family))


def read_motor_side(robot: RobotDescription, recording: Recording, family: str = "motor.position") -> Array:
    """Read measured or set positions, speeds or accelerations of motors, motor side, shape (T, N)."""
    values = recording.joint_array(family)
    return robot.drive.motor_angle(values) if recording.header.position_side == "link" else values


def convert_to_motor_side(drive: Drive, header: Header, torque: Array) -> Array:
    """Bring torques (T, N) of a recording to the motor side [N m]; those of currents and commands are there."""
    return drive.motor_torque(torque) if header.torque_semantics == "link_side" else torque


def convert_to_recorded_side(drive: Drive, header: Header, torque: Array) -> Array:
    """Bring torques (T, N), motor side [N m], to the side of a recording."""
    return drive.joint_torque(torque) if header.torque_semantics == "link_side" else torque


def read_joint_position(robot: RobotDescription, recording: Recording, low_pass: LowPass) -> Array:
    """Filter positions behind the gearbox from motor angles, without delay; SI, shape (T, N).

    Raises:
        FFGymError: if robot and recording do not fit, or it is sampled unevenly, too slowly or too shortly.
    """
    check_fits(robot, recording)
    if not is_even(recording.t):
        raise FFGymError(
            f"Recording {recording.header.segment!r} is sampled unevenly, every {np.diff(recording.t).min():g} to "
            f"{np.diff(recording.t).max():g} s; ffgym.logs.condition brings it to even times."
        )
    return low_pass(read_joint_side(robot, recording), recording.dt)


def read_joint_motion(robot: RobotDescription, recording: Recording, low_pass: LowPass) -> tuple[Array, Array, Array]:
    """Compute position, speed and acceleration behind the gearbox from motor angles, by differences of rows."""
    q = read_joint_position(robot, recording, low_pass)
    dq = np.gradient(q, recording.dt, axis=0)
    return q, dq, np.gradient(dq, recording.dt, axis=0)


def read_motor_torque(robot: RobotDescription, recording: Recording, family: str = "motor.effort") -> Array:
    """Read torques of a family, motor side [N m], shape (T, N), row by row as they stand in the recording.

    Raises:
        FFGymError: if robot and recording do not fit, or it does not say what its torque is.
    """
    check_fits(robot, recording)
    header = recording.header
    if header.torque_semantics == "unspecified":
        raise FFGymError(f"Recording {header.segment!r} does not say what its torque is: torque_semantics.")
    return convert_to_motor_side(robot.drive, header, recording.joint_array(family))


def read_acting_torque(robot: RobotDescription, recording: Recording, family: str = "motor.effort") -> Array:
    """Read torques of a family that act about the time of each row, motor side [N m], shape (T, N)."""
    torque, hold = read_motor_torque(robot, recording, family), recording.header.hold
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
