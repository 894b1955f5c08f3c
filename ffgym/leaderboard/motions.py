"""Motions that are scored beside circles: squares with rounded corners, and spirals, as motion files."""

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
    if kind == SQUARE:
        return follow_square(arm, centre, size, speed, name)
    return _follow(arm, _write(centre), _spiral(size, speed), name)


def follow_square(
    arm: RigidArm,
    centre: _Point | str,
    half: float,
    speed: float,
    name: str,
    *,
    zone: float = ZONE,
    from_corner: bool = False,
) -> Reference:
    """Make the reference of a square with rounded corners about a point [m], or a named point of the work area.

    Args:
        arm: nominal model of the robot.
        centre: centre of the square.
        half: half a side [m].
        speed: programmed speed [m/s].
        name: name of the motion.
        zone: rounding of a corner, in half a side.
        from_corner: whether the motion begins and ends at a corner, which is not rounded then, or in the middle of a
            side.

    Raises:
        FFGymError: if the robot cannot follow the motion.
    """
    begin = (-1.0, -1.0) if from_corner else (0.0, -1.0)
    corners = [begin, (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0)]
    corners += [] if from_corner else [begin]
    lines = []
    for k, (x, y) in enumerate(corners):
        rounded = f", zone = {zone * half:.6f}" if 0 < k < len(corners) - 1 else ""
        lines.append(f'{{ kind = "line", to = {_write((x * half, y * half, 0.0))}, speed = {speed:g}{rounded} }}')
    return _follow(arm, f'"{centre}"' if isinstance(centre, str) else _write(centre), ", ".join(lines), name)


def _spiral(last: float, speed: float) -> str:
    """Write a spline through points whose radius grows evenly with their angle."""
    count = TURNS * PER_TURN
    points = []
    for k in range(count + 1):
        radius, angle = last * k / count, 2 * math.pi * k / PER_TURN
        points.append(_write((radius * math.cos(angle), radius * math.sin(angle), 0.0)))
    return f'{{ kind = "spline", speed = {speed:g}, through = [{", ".join(points)}] }}'


def _follow(arm: RigidArm, origin: str, parts: str, name: str) -> Reference:
    """Make the reference of the parts of a motion file about its origin, both as TOML."""
    text = f"origin = {origin}\npart = [{parts}]\n"
    return parse_motion(arm, text, where=f"the motion {name!r}", name=name).reference


def _write(point: _Point) -> str:
    """Write a point with a resolution of a micrometre."""
    return f"[{point[0]:.6f}, {point[1]:.6f}, {point[2]:.6f}]"
