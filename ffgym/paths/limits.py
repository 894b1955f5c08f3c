"""Speed limits along a path: limits of tool and joints, bounds on speed along a path, and stretches within them."""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from ffgym.core.errors import FFGymError, check_number, check_shape
from ffgym.core.types import Array
from ffgym.paths.motions.part import entry
from ffgym.paths.moves import Speed
from ffgym.paths.route import Course
from ffgym.paths.timing import PathStretch

JOINT_ACCELERATION = 12.5
"""Default largest acceleration of a joint on any path, in its largest speeds per second; chosen: the thesis' fastest
circle takes 8.2 on the built-in robot, and a curve at constant speed may use 80 % (CURVE_SHARE)."""
JOINT_JERK = 2000.0
"""Default largest jerk of a joint on any path, in its largest speeds per second squared; chosen: the thesis' fastest
circle takes 1215, and a curve at constant speed may use 80 % (CURVE_SHARE)."""


LEAST, MOST = 1e-6, 1e9
"""Range of all limits, in SI units: beyond it rounding would rule, and no machine is."""


@dataclass(frozen=True, kw_only=True, eq=False)
class MotionLimits:
    """Limits of a motion, beside the programmed speeds and the robot's joint speeds. None takes the documented default.

    They bound what is asked of tool and joints; whether the motors can give the torque, a simulation shows.
    """

    acceleration: float = entry(
        "of the tool along its path; a fifth of gravity is ordinary for process moves", "m/s^2", default=2.0
    )
    jerk: float = entry("of the tool along its path; acceleration builds up in 50 ms", "m/s^3", default=40.0)
    normal_acceleration: float = entry(
        "of the tool across its path, speed squared times curvature; a circle of 1 mm at 100 mm/s takes 10",
        "m/s^2",
        default=12.5,
    )
    turn_acceleration: float = entry(
        "of the tool's orientation; that along the path on an arm of 0.1 m, the size of a tool", "rad/s^2", default=20.0
    )
    turn_jerk: float = entry("of the tool's orientation; likewise", "rad/s^3", default=400.0)
    joint_speed: float = entry(
        "share of the robot's largest joint speeds that may be used, in (0, 1]", "1", default=1.0
    )
    joint_rise: float = entry(
        "acceleration of joint moves, in largest speeds of the joints; half a second to full speed", "1/s", default=2.0
    )
    joint_rise_jerk: float = entry(
        "jerk of joint moves, in largest speeds of the joints; acceleration builds up in 50 ms", "1/s^2", default=40.0
    )
    joint_acceleration: Array | None = entry(
        "of each joint on any path, link side; absent is 12.5 largest speeds per s", "rad/s^2 or m/s^2", default=None
    )
    joint_jerk: Array | None = entry(
        "of each joint on any path, link side; absent is 2000 largest speeds per s^2", "rad/s^3 or m/s^3", default=None
    )

    def __post_init__(self) -> None:
        check_number("joint_speed", self.joint_speed, low=0.0, high=1.0, open_low=True)
        for limit in fields(self):
            name, given = limit.name, getattr(self, limit.name)
            if name in ("joint_acceleration", "joint_jerk"):
                if given is not None:
                    value = check_shape(name, given, (None,))
                    if not np.all((value >= LEAST) & (value <= MOST)):
                        raise FFGymError(f"{name} = {value.tolist()} must be in [{LEAST}, {MOST}] for every joint.")
                    object.__setattr__(self, name, value)
            elif name != "joint_speed":
                check_number(name, given, unit=limit.metadata["unit"], low=LEAST, high=MOST)

    def of_joints(self, max_speed: Array) -> "Bounds":
        """Limits of joints whose largest speeds are `max_speed`, link side, shape (N,)."""
        acceleration, jerk = self.joint_acceleration, self.joint_jerk
        for name, given in (("joint_acceleration", acceleration), ("joint_jerk", jerk)):
            if given is not None and given.shape != max_speed.shape:
                raise FFGymError(f"{name} has {len(given)} entries, must have one for each of {len(max_speed)} joints.")
        return Bounds(
            speed=max_speed * self.joint_speed,
            acceleration=max_speed * JOINT_ACCELERATION if acceleration is None else acceleration,
            jerk=max_speed * JOINT_JERK if jerk is None else jerk,
        )


CURVE_SHARE = 0.8
"""Share of a joint's acceleration and jerk that constant speed along a curve may take; what it leaves is for changes of
speed. Chosen: near 1 a robot in a curve could hardly brake, and at 0.5 curves would be slow."""
MARGIN = 0.98
"""Share of a limit that is used; chosen: bounds are taken on a grid along the path, between whose points a quantity may
be larger by less than 2 %."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Bounds:
    """Largest speed, acceleration and jerk: along a path at points of it, shape (T,), or of each axis, shape (N,)."""

    speed: Array
    acceleration: Array
    jerk: Array


def axis_bounds(slopes: Sequence[Array], limits: Bounds, cap: Bounds) -> Bounds:
    r"""Bounds on a path parameter s that keep axes q(s) within limits, at points of the path.

    With :math:`\ddot q = q' \ddot s + q'' \dot s^2` and
    :math:`\dddot q = q' \dddot s + 3 q'' \dot s \ddot s + q''' \dot s^3`, speed is bounded first, such that the terms
    in it alone take at most CURVE_SHARE; acceleration and jerk get what is left at that speed, the mixed term at most
    half of it.

    Args:
        slopes: q', q'' and q''', each of shape (T, N).
        limits: of the axes.
        cap: what else holds; speeds are as low as they need be, and not above it.
    """
    first, second, third = (np.abs(slope) for slope in slopes)
    a_max, j_max = MARGIN * limits.acceleration, MARGIN * limits.jerk
    speed = np.minimum.reduce(
        [
            cap.speed,
            _least(MARGIN * limits.speed, first),
            np.sqrt(_least(CURVE_SHARE * a_max, second)),
            np.cbrt(_least(CURVE_SHARE * j_max, third)),
        ]
    )
    v = speed[:, None]
    left_a, left_j = a_max - second * v**2, j_max - third * v**3
    acceleration = np.minimum.reduce([cap.acceleration, _least(left_a, first), _least(left_j / 2, 3 * second * v)])
    mixed = 3 * second * v * acceleration[:, None]
    jerk = np.minimum(cap.jerk, _least(left_j - mixed, first))
    return Bounds(speed=speed, acceleration=acceleration, jerk=jerk)


def tool_bounds(speed: Speed | None, s: Array, course: Course, limits: MotionLimits) -> Bounds:
    """Bounds from the programmed speed and the limits of the tool, at arc lengths `s` of a leg, shape (T,)."""
    _, tangent, bend, _ = course.path
    moving, across = (np.linalg.norm(part, axis=1)[:, None] for part in (tangent, bend))  # 1, or 0 where it only turns
    programmed = np.inf if speed is None else speed.tcp
    shares = (1.0, 1.0) if speed is None else (speed.acceleration, speed.jerk)
    cap = Bounds(
        speed=np.minimum(_least(programmed, moving), np.sqrt(_least(limits.normal_acceleration, across))),
        acceleration=_least(limits.acceleration * shares[0], moving),
        jerk=_least(limits.jerk * shares[1], moving),
    )
    if course.turned is None:
        return cap
    turn = np.inf if speed is None else speed.turn
    axis = Bounds(
        speed=np.array([turn]),
        acceleration=np.array([limits.turn_acceleration * shares[0]]),
        jerk=np.array([limits.turn_jerk * shares[1]]),
    )
    _, rate, change = course.turned
    slopes = (rate, change, slope_of(change, s))
    return axis_bounds([np.linalg.norm(slope, axis=1)[:, None] for slope in slopes], axis, cap)


def slope_of(values: Array, s: Array) -> Array:
    """Derivative of `values` (T, D) by arc length, by differences on the grid, of second order to its ends."""
    return np.gradient(values, s, axis=0, edge_order=2)


def _least(limit: Array | float, slope: Array) -> Array:
    """Smallest limit / slope over the axes of `slope` (T, N), shape (T,); infinite where nothing moves."""
    ratio = np.full(slope.shape, np.inf)
    with np.errstate(over="ignore"):  # beyond all numbers is no bound either
        np.divide(limit, slope, out=ratio, where=slope > 0)
    least: Array = ratio.min(axis=1)
    return least


VARIATION = 1.5
"""Ratio of the highest to the lowest speed bound beyond which a leg is halved; chosen: a third of the speed lost at
most, against time lost where stretches meet without acceleration."""
FEWEST = 4
"""Intervals in a stretch at least."""
SIMILAR = 2.0
"""Ratio of accelerations and jerks up to which stretches of one speed are run as one; chosen as VARIATION."""


def stretches(grid: Sequence[Array], bounds: Sequence[Bounds]) -> list[PathStretch]:
    """Stretches that respect the bounds at every point of the grid.

    Args:
        grid: arc lengths at which each leg was examined, shape (K,) each.
        bounds: of each leg, at these points.
    """
    parts = [part for s, bound in zip(grid, bounds, strict=True) for part in _halve(s, bound, 0, len(s) - 1)]
    groups: list[list[PathStretch]] = []
    for part in parts:
        # stretches of one speed, whose accelerations and jerks are similar, are run as one
        group = [*groups[-1], part] if groups else []
        a, j = [p.acceleration for p in group], [p.jerk for p in group]
        one_speed = len({p.speed for p in group}) == 1
        if one_speed and max(a) <= SIMILAR * min(a) and max(j) <= SIMILAR * min(j):
            groups[-1] = group
        else:
            groups.append([part])
    return [
        PathStretch(
            length=float(np.sum([part.length for part in group])),
            speed=group[0].speed,
            acceleration=min(part.acceleration for part in group),
            jerk=min(part.jerk for part in group),
        )
        for group in groups
    ]


def _halve(s: Array, bound: Bounds, first: int, last: int) -> list[PathStretch]:
    """Halve stretches between two points of the grid until the speed bound varies little within each."""
    rows = slice(first, last + 1)
    speed = bound.speed[rows]
    middle = (first + last) // 2
    if speed.max() > VARIATION * speed.min() and middle - first >= FEWEST:
        return _halve(s, bound, first, middle) + _halve(s, bound, middle, last)
    whole = PathStretch(
        length=float(s[last] - s[first]),
        speed=float(speed.min()),
        acceleration=float(bound.acceleration[rows].min()),
        jerk=float(bound.jerk[rows].min()),
    )
    return [whole]
