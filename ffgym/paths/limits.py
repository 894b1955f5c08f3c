"""How fast a path may be run: limits of the tool and of the joints, their defaults and the reasons."""

from dataclasses import dataclass

import numpy as np

from ffgym.core.errors import FFGymError, check_number, check_shape
from ffgym.core.types import Array

ACCELERATION = 2.0
"""Default acceleration of the tool along its path [m/s^2]; chosen: a fifth of gravity, ordinary for process moves; the
thesis' 100 mm/s are reached within 0.1 s."""
JERK = 40.0
"""Default jerk of the tool along its path [m/s^3]; chosen: acceleration builds up in 50 ms, a dozen
samples of the drive."""
NORMAL_ACCELERATION = 12.5
"""Default acceleration of the tool across its path [m/s^2]; chosen: the thesis runs a 1 mm circle at 100 mm/s, which
takes 10 m/s^2, and circles must run at their speed."""
TURN_ARM = 0.1
"""Arm at which a turning tool moves as fast as its limits along the path say [m]; chosen: the size of a tool."""
JOINT_RISE = 2.0
"""Default acceleration of joint moves, in largest speeds per second; chosen: half a second to full speed, less
than half of what the weakest drive of the built-in robot can do against its inertia (5.4)."""
JOINT_RISE_JERK = 40.0
"""Default jerk of joint moves, in largest speeds per second squared; chosen: acceleration builds up in 50 ms."""
JOINT_ACCELERATION = 12.5
"""Default largest acceleration of a joint on any path, in its largest speeds per second; chosen: the thesis' fastest
circle takes 8.2 on the built-in robot, and a curve at constant speed may use 80 % (see `bounds`)."""
JOINT_JERK = 2000.0
"""Default largest jerk of a joint on any path, in its largest speeds per second squared; chosen: the thesis' fastest
circle takes 1215, and a curve at constant speed may use 80 % (see `bounds`)."""


LEAST, MOST = 1e-6, 1e9
"""Range of all limits, in SI units: beyond it rounding would rule, and no machine is."""

_UNITS = {
    "acceleration": "m/s^2",
    "jerk": "m/s^3",
    "normal_acceleration": "m/s^2",
    "turn_acceleration": "rad/s^2",
    "turn_jerk": "rad/s^3",
    "joint_rise": "1/s",
    "joint_rise_jerk": "1/s^2",
}


@dataclass(frozen=True, kw_only=True, eq=False)
class MotionLimits:
    """Limits of a motion, beside the programmed speeds and the robot's joint speeds. None takes the documented default.

    They bound what is asked of tool and joints; whether the motors can give the torque, a simulation shows.
    """

    acceleration: float = ACCELERATION
    """Of the tool along its path [m/s^2], > 0."""
    jerk: float = JERK
    """Of the tool along its path [m/s^3], > 0."""
    normal_acceleration: float = NORMAL_ACCELERATION
    """Of the tool across its path, speed squared times curvature [m/s^2], > 0."""
    turn_acceleration: float = ACCELERATION / TURN_ARM
    """Of the tool's orientation [rad/s^2], > 0."""
    turn_jerk: float = JERK / TURN_ARM
    """Of the tool's orientation [rad/s^3], > 0."""
    joint_speed: float = 1.0
    """Share of the robot's largest joint speeds that may be used, in (0, 1]."""
    joint_rise: float = JOINT_RISE
    """Acceleration of joint moves, in largest speeds of the joints per second [1/s], > 0."""
    joint_rise_jerk: float = JOINT_RISE_JERK
    """Jerk of joint moves, in largest speeds of the joints per second squared [1/s^2], > 0."""
    joint_acceleration: Array | None = None
    """Of each joint on any path, link side [rad/s^2 or m/s^2], shape (N,), > 0; None is 12.5 largest speeds per s."""
    joint_jerk: Array | None = None
    """Of each joint on any path, link side [rad/s^3 or m/s^3], shape (N,), > 0; None is 2000 largest speeds per s^2."""

    def __post_init__(self) -> None:
        for name, unit in _UNITS.items():
            check_number(name, getattr(self, name), unit=unit, low=LEAST, high=MOST)
        check_number("joint_speed", self.joint_speed, low=0.0, high=1.0, open_low=True)
        for name in ("joint_acceleration", "joint_jerk"):
            given = getattr(self, name)
            if given is not None:
                value = check_shape(name, given, (None,))
                if not np.all((value >= LEAST) & (value <= MOST)):
                    raise FFGymError(f"{name} = {value.tolist()} must be in [{LEAST}, {MOST}] for every joint.")
                object.__setattr__(self, name, value)

    def of_joints(self, max_speed: Array) -> "AxisLimits":
        """Limits of joints whose largest speeds are `max_speed`, link side, shape (N,).

        Raises:
            FFGymError: if limits are given for another number of joints.
        """
        acceleration, jerk = self.joint_acceleration, self.joint_jerk
        for name, given in (("joint_acceleration", acceleration), ("joint_jerk", jerk)):
            if given is not None and given.shape != max_speed.shape:
                raise FFGymError(f"{name} has {len(given)} entries, must have one for each of {len(max_speed)} joints.")
        return AxisLimits(
            speed=max_speed * self.joint_speed,
            acceleration=max_speed * JOINT_ACCELERATION if acceleration is None else acceleration,
            jerk=max_speed * JOINT_JERK if jerk is None else jerk,
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class AxisLimits:
    """Largest speed, acceleration and jerk of each axis, shape (N,) each."""

    speed: Array
    acceleration: Array
    jerk: Array
