"""Bounds on the speed along a path that keep tool and joints within their limits, at points of the path."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ffgym.core.types import Array
from ffgym.paths.limits import AxisLimits, MotionLimits
from ffgym.paths.moves import Speed
from ffgym.paths.route import Course

CURVE_SHARE = 0.8
"""Share of a joint's acceleration and jerk that constant speed along a curve may take; what it leaves is for changes of
speed. Chosen: near 1 a robot in a curve could hardly brake, and at 0.5 curves would be slow."""
MARGIN = 0.98
"""Share of a limit that is used; chosen: bounds are taken on a grid along the path, between whose points a quantity may
be larger by less than 2 %."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Bounds:
    """Largest speed, acceleration and jerk along a path at points of it, shape (T,) each."""

    speed: Array
    acceleration: Array
    jerk: Array


def axis_bounds(slopes: Sequence[Array], limits: AxisLimits, cap: Bounds) -> Bounds:
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
    cap = Bounds(
        speed=np.minimum(_least(programmed, moving), np.sqrt(_least(limits.normal_acceleration, across))),
        acceleration=_least(limits.acceleration, moving),
        jerk=_least(limits.jerk, moving),
    )
    if course.turned is None:
        return cap
    turn = np.inf if speed is None else speed.turn
    axis = AxisLimits(
        speed=np.array([turn]),
        acceleration=np.array([limits.turn_acceleration]),
        jerk=np.array([limits.turn_jerk]),
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
