"""What a robot looks like that says nothing of its looks: a rod from each joint to the next, a ball on each joint."""

import numpy as np

from ffgym.core.types import Array
from ffgym.robot.description import RobotDescription
from ffgym.robot.shapes import Geom

THICKNESS = 0.02
"""Radius of a rod over the length of the whole chain; chosen: as slender as an arm with its castings."""
_SHORTEST = 0.1
"""Rods shorter than this share of their radius are left out: their joints' balls cover them."""
ROD = (0.55, 0.6, 0.66, 1.0)
BALL = (0.25, 0.3, 0.36, 1.0)
"""Colours: red, green, blue, opacity."""


def stick_figure(robot: RobotDescription) -> tuple[Geom, ...]:
    """Shapes of a robot, made of the positions of its joints and its tool."""
    ends = dict(zip(("base", *robot.links), robot.kinematics.position, strict=False))
    ends[robot.links[-1]] = robot.bodies.com[-1] if robot.tool is None else robot.tool.position
    if robot.tool is not None:
        ends["tool"] = robot.tool.tcp
    length = sum(float(np.linalg.norm(end)) for end in ends.values())
    radius = THICKNESS * (length or 1.0)
    rods = [_rod(body, end, radius) for body, end in ends.items() if np.linalg.norm(end) > _SHORTEST * radius]
    balls = [
        Geom(body=link, type="sphere", size=(1.5 * radius,), pos=(0.0, 0.0, 0.0), end=None, colour=BALL)
        for link in robot.links
    ]
    return (*rods, *balls)


def _rod(body: str, end: Array, radius: float) -> Geom:
    x, y, z = end.tolist()
    return Geom(body=body, type="capsule", size=(radius,), pos=(0.0, 0.0, 0.0), end=(x, y, z), colour=ROD)
