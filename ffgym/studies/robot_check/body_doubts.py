"""Numbers of links and geometry that are valid but hardly true: mostly slips of unit or frame."""

from collections.abc import Iterator

import numpy as np

from ffgym.robot import RobotDescription
from ffgym.studies.robot_check.draft import skeleton

_FAR = 1.5
"""Centre of mass from its joint, in lengths of the longest link: beyond it, it lies outside any usual link."""
_WIDE = 2.0
"""Half axis of a link's inertia ellipsoid, in lengths of the longest link; a thin rod has 0.65 of its own length."""
_DENSEST = 20e3
"""kg/m^3, above gold and tungsten with 19.3e3: a body that needs more to fit its inertia has too little of it."""
_EARTH = (9.7, 9.9)
"""Gravity on the ground [m/s^2], with room for rounding."""


def far_masses(robot: RobotDescription) -> Iterator[str]:
    """Centres of mass that are far from their links."""
    longest = _longest_link(robot)
    for link, com in zip(robot.links, robot.bodies.com, strict=True):
        distance = float(np.linalg.norm(com))
        if 0 < longest * _FAR < distance:
            yield (
                f"links.com: the centre of mass of {link} is {distance:.3g} m from its joint, while the longest link "
                f"has {longest:.3g} m. Is it in the link frame, and in m?"
            )


def odd_inertias(robot: RobotDescription) -> Iterator[str]:
    """Inertias that are too large or too small for mass and link."""
    longest = _longest_link(robot)
    bones = skeleton(robot, np.clip(0.0, *robot.kinematics.range.T))
    for body, mass, half_axes in zip(bones.bodies, bones.mass, bones.half_axes, strict=True):
        largest = float(half_axes.max())
        if 0 < longest * _WIDE < largest:
            yield (
                f"links.inertia: mass and inertia of {body} belong to a body of {2 * largest:.3g} m, while the longest "
                f"link has {longest:.3g} m. Is the inertia about the centre of mass, and in kg m^2?"
            )
        if mass > _DENSEST * 4 / 3 * np.pi * largest**3:
            yield (
                f"links.inertia: {mass:.3g} kg of {body} would fit into {2e3 * largest:.3g} mm only if denser than "
                f"gold. Is the inertia in kg m^2?"
            )


def odd_gravity(robot: RobotDescription) -> Iterator[str]:
    """Gravity that is neither none nor the earth's."""
    size = float(np.linalg.norm(robot.gravity))
    if size > 0 and not _EARTH[0] <= size <= _EARTH[1]:
        yield f"simulation.gravity is {size:.4g} m/s^2, on the ground it is 9.81."


def _longest_link(robot: RobotDescription) -> float:
    """Longest distance between neighbouring joints, or the last one and the TCP [m]; 0 for one joint without tool."""
    steps = [*robot.kinematics.position[1:]]
    if robot.tool is not None:
        steps.append(robot.tool.position + robot.tool.rotation @ robot.tool.tcp)
    return max((float(np.linalg.norm(step)) for step in steps), default=0.0)
