"""What a robot carries beside its tool."""

from dataclasses import replace

import numpy as np

from ffgym.core.errors import FFGymError, check_number
from ffgym.core.types import Array
from ffgym.robot.description import RobotDescription
from ffgym.robot.parts import point_mass_inertia


def with_payload(
    robot: RobotDescription, mass: float, offset: Array | None = None, radius: float = 0.0
) -> RobotDescription:
    """Return the robot with a load at its TCP; a point mass is a small ball, if the tool itself weighs nothing.

    Args:
        robot: who carries it.
        mass: [kg].
        offset: centre of mass from the TCP, in the axes of tool0 [m], shape (3,); None is none.
        radius: of gyration about any axis through the centre of mass [m].

    Raises:
        FFGymError: if the robot has no tool, or the mass is negative.
    """
    mass = check_number("payload", mass, unit="kg", low=0.0)
    if robot.tool is None:
        raise FFGymError(f"Robot {robot.name!r} has no tool, so it can carry no payload.")
    tool = robot.tool
    total = tool.mass + mass
    if total == 0:
        return robot
    place = tool.tcp if offset is None else tool.tcp + offset
    own = mass * radius**2 * np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
    if tool.mass == 0:
        inertia = own if radius > 0 else point_mass_inertia(mass)
        return replace(robot, tool=replace(tool, mass=mass, com=place, inertia=inertia))
    com = (tool.mass * tool.com + mass * place) / total
    inertia = tool.inertia + tool.mass * _about(tool.com - com) + mass * _about(place - com) + own
    return replace(robot, tool=replace(tool, mass=total, com=com, inertia=inertia))


def _about(arm: Array) -> Array:
    """Inertia of a unit point mass at `arm` (3,) [m] about the origin, order xx, yy, zz, xy, xz, yz."""
    x, y, z = arm
    return np.array([y * y + z * z, x * x + z * z, x * x + y * y, -x * y, -x * z, -y * z])
