"""Motions that a verification draws beside circles: squares with rounded corners, and spirals, as motion files."""

import math

from ffgym.paths import Reference
from ffgym.paths.motions.load import parse_motion
from ffgym.robot import RigidArm

CIRCLE, SQUARE, SPIRAL, TILTED = KINDS = ("circle", "square", "spiral", "tilted")
"""Kinds of motions: a circle in the plane of the work area, a square with rounded corners, a spiral, both parallel to
the ground, and a circle in a tilted plane."""
ZONE = 0.4
"""Rounding of a corner, in half a side of the square; chosen, as in the built-in motion `rounded_square`."""
TURNS, PER_TURN = 2, 8
"""Turns of a spiral, and points of its spline in each; chosen, as in the built-in motion `spiral`, less a turn."""

_Point = tuple[float, float, float]


def follow_shape(arm: RigidArm, kind: str, centre: _Point, size: float, speed: float, name: str) -> Reference:
    """Make the reference of a square or a spiral about a point of the world [m].

    Args:
        arm: nominal model of the robot.
        kind: SQUARE or SPIRAL.
        centre: centre of the square, or beginning of the spiral [m].
        size: half a side of the square, or last radius of the spiral [m].
        speed: programmed speed [m/s]; the robot slows down where its limits ask for it.
        name: name of the motion.

    Raises:
        FFGymError: if the robot cannot follow the motion.
    """
    parts = _square(size, speed) if kind == SQUARE else _spiral(size, speed)
    text = f"origin = {_write(centre)}\npart = [{parts}]\n"
    return parse_motion(arm, text, where=f"the {kind} {name!r}", name=name).reference


def _square(half: float, speed: float) -> str:
    """Write lines from the middle of a side, where the motion begins, round the corners and back to it."""
    corners = [(0, -1), (1, -1), (1, 1), (-1, 1), (-1, -1), (0, -1)]
    lines = []
    for k, (x, y) in enumerate(corners):
        zone = f", zone = {ZONE * half:.6f}" if 1 <= k <= 4 else ""
        lines.append(f'{{ kind = "line", to = {_write((x * half, y * half, 0.0))}, speed = {speed:g}{zone} }}')
    return ", ".join(lines)


def _spiral(last: float, speed: float) -> str:
    """Write a spline through points whose radius grows evenly with their angle."""
    count = TURNS * PER_TURN
    points = []
    for k in range(count + 1):
        radius, angle = last * k / count, 2 * math.pi * k / PER_TURN
        points.append(_write((radius * math.cos(angle), radius * math.sin(angle), 0.0)))
    return f'{{ kind = "spline", speed = {speed:g}, through = [{", ".join(points)}] }}'


def _write(point: _Point) -> str:
    """Write a point with a resolution of a micrometre."""
    return f"[{point[0]:.6f}, {point[1]:.6f}, {point[2]:.6f}]"
