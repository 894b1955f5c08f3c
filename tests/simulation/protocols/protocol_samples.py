"""Robots that protocols are asked about, and their motions, made once."""

from dataclasses import replace
from functools import cache

from ffgym.robot import RigidArm, builtin_robots, load_robot
from ffgym.simulation.protocols import PROTOCOLS
from tests.robot.robot_samples import unusual

UNUSUAL = "unusual"
ROBOTS = (*builtin_robots(), UNUSUAL)
CASES = [(robot, name) for robot in ROBOTS for name in PROTOCOLS]


def described(robot):
    """A built-in robot, or one with a rail, a coupled wrist and a motor that turns backwards."""
    if robot != UNUSUAL:
        return load_robot(robot)
    return replace(unusual(load_robot("irb4600_60_205")), work_area=None)


@cache
def arm_of(robot):
    """Rigid dynamics of `described`."""
    return RigidArm(described(robot))


def protocol_for(robot, name):
    """A protocol with its defaults, but for the last joint or the first position alone where each has its own."""
    known = arm_of(robot).robot
    if name in ("speed_ladder", "table_6_1", "slow_triangles"):
        return PROTOCOLS[name](joints=known.joints[-1:])
    if name == "circles" and known.work_area is not None:
        return PROTOCOLS[name](positions=[*known.work_area.positions][:1])
    return PROTOCOLS[name]()


@cache
def schedule_of(robot, name):
    """Motions of `protocol_for`."""
    return protocol_for(robot, name).schedule(arm_of(robot))
