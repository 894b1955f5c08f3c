"""Rows in which a description that knows no friction at low speed cannot say what a motor takes."""

import numpy as np
from scipy.ndimage import maximum_filter1d

from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.log import Log
from ffgym.robot import RobotDescription

SLOW = 0.01
"""Share of a joint's largest speed below which bristles decide the torque. On recorded robots of 300 kg, 0.02 rad/s:
there Coulomb and viscous friction miss the torque by five to ten times as much as above it."""

_PEAK = 1e-6
"""Relative difference of breakaway and Coulomb torque from which on a description has a peak at low speed."""


def knows_low_speed(robot: RobotDescription) -> BoolArray:
    """Joints whose description has more than Coulomb and viscous friction: a breakaway peak, shape (N,)."""
    friction = robot.friction
    knows: BoolArray = friction.static > (1 + _PEAK) * friction.coulomb
    return knows


def judged_rows(log: Log) -> BoolArray:
    """Rows that count for the torque of each motor, shape (R, M, N).

    All of them where the description knows low speeds; else those in whose reach of the low-pass the motor never was
    slow: what it takes to hold still, between plus and minus the breakaway torque, is not determined by its motion.
    """
    sampling, robot = log.sampling, log.robot
    slow = np.abs(_speed(log)) < SLOW * robot.kinematics.max_speed
    near = maximum_filter1d(slow.astype(np.int8), 2 * sampling.half_length + 1, axis=0)[sampling.at] > 0
    judged: BoolArray = knows_low_speed(robot) | ~near
    return judged


def _speed(log: Log) -> Array:
    """Speed behind the gearbox of the motor alone [rad/s], (T, M, N): what other joints turn it by counts too."""
    drive = log.robot.drive
    return drive.motor_angle(log.dq) / drive.gear_ratio
