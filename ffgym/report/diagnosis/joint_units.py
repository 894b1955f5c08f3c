"""Sizes and residuals of sliding joints in N, m and kg behind the gearbox, where they are read; motors keep N m."""

from dataclasses import replace
from typing import Any

from ffgym.diagnosis.residual import UNITS, Channel
from ffgym.diagnosis.result import Cause, Diagnosis, Level, Size
from ffgym.effects import EFFECTS
from ffgym.report.diagnosis.models import FINE
from ffgym.robot import RobotDescription

BEHIND = {
    "N m": ("N", 1),
    "N m/rad": ("N/m", 2),
    "N m s/rad": ("N s/m", 2),
    "N m/A": ("N/A", 1),
    "kg m^2": ("kg", 2),
    "rad": ("m", -1),
    "rad/s": ("m/s", -1),
}
"""Unit of a hinge or a motor -> unit of a sliding joint, and the power of the gear ratio [rad/m] that brings a number
of the motor behind the gearbox."""

_NUMBERS = ("measured", "noise_floor", "before", "after")
"""What a level holds in its unit."""


def scale_of(robot: RobotDescription, channel: Channel, joint: int) -> tuple[float, str]:
    """Factor and unit in which a quantity of a joint is shown."""
    return _behind(robot, joint, UNITS[channel], motor=channel != "link")


def fine_scale_of(robot: RobotDescription, channel: Channel, joint: int) -> tuple[float, str]:
    """Factor and unit in which people read a residual of a joint."""
    factor, unit = scale_of(robot, channel, joint)
    fine, named = FINE[unit]
    return factor * fine, named


def in_joint_units(diagnosis: Diagnosis, robot: RobotDescription | None) -> Diagnosis:
    """The diagnosis with sizes and levels of sliding joints behind the gearbox; as it is without one."""
    if robot is None or not robot.kinematics.is_sliding.any():
        return diagnosis
    causes = tuple(_cause(cause, robot) for cause in diagnosis.causes)
    levels = tuple(_level(level, robot) for level in diagnosis.levels)
    return replace(diagnosis, causes=causes, levels=levels)


def _cause(cause: Cause, robot: RobotDescription) -> Cause:
    if cause.joint not in robot.joints or cause.effect not in EFFECTS:
        return cause
    joint, motor = robot.joints.index(cause.joint), EFFECTS[cause.effect].side == "motor"
    return replace(cause, parameters=tuple(_size(size, robot, joint, motor=motor) for size in cause.parameters))


def _size(size: Size, robot: RobotDescription, joint: int, *, motor: bool) -> Size:
    factor, unit = _behind(robot, joint, size.unit, motor=motor)
    low, high = sorted(factor * end for end in size.interval)
    return replace(size, value=factor * size.value, unit=unit, interval=(low, high))


def _level(level: Level, robot: RobotDescription) -> Level:
    if level.component not in robot.joints:
        return level
    joint = robot.joints.index(level.component)
    factor, unit = _behind(robot, joint, level.unit, motor=level.channel != "link")
    numbers: dict[str, Any] = {name: factor * getattr(level, name) for name in _NUMBERS}
    return replace(level, unit=unit, **numbers)


def _behind(robot: RobotDescription, joint: int, unit: str, *, motor: bool) -> tuple[float, str]:
    """Factor and unit behind the gearbox of a number of a sliding joint; 1 and the unit as it is for all others."""
    if not robot.kinematics.is_sliding[joint] or unit not in BEHIND:
        return 1.0, unit
    named, power = BEHIND[unit]
    return (abs(float(robot.drive.gear_ratio[joint])) ** power if motor else 1.0), named
