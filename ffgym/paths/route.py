"""A path without time: legs one after another, how the tool turns along them, corners rounded."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np
import scipy

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.paths.curves import Curve, Derivatives, Part, blend
from ffgym.paths.moves import Speed

Turned = tuple[Array, Array, Array]
"""Orientation (T, 3, 3), its rate by arc length and the rate of that, in world axes [rad/m, rad/m^2], (T, 3)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class EvenTurn:
    """The tool turns about one axis of the world at a constant rate; a rate of zero keeps the orientation."""

    start: Array
    """Orientation at s = 0, shape (3, 3)."""
    rate: Array
    """Rotation vector by arc length, world axes [rad/m], shape (3,)."""

    def at(self, s: Array) -> Turned:
        """Orientation and rates at arc lengths `s`."""
        rotation = scipy.spatial.transform.Rotation.from_rotvec(s[:, None] * self.rate).as_matrix() @ self.start
        still = np.zeros((len(s), 3))
        return rotation, still + self.rate, still


@dataclass(frozen=True, kw_only=True, eq=False)
class BlendedTurn:
    r"""Around a corner: the turn before it fades out while the turn after it fades in.

    .. math:: R(s) = e^{f(s) \omega_0} e^{g(s) \omega_1} R_c

    where f rises from minus the length that the corner cuts off a leg to 0 and g from 0 to that length, both as
    quintics. Orientation, rate and its derivative equal those of the legs at both ends.
    """

    corner: Array
    """Orientation that was asked for at the corner, shape (3, 3)."""
    before: Array
    """Rate omega_0 of the leg before [rad/m], shape (3,)."""
    after: Array
    """Rate omega_1 of the leg after [rad/m], shape (3,)."""
    cut: float
    """Arc length of the legs from where the blend starts to the corner, and from the corner to where it ends."""
    length: float
    """Arc length of the blend."""

    def at(self, s: Array) -> Turned:
        """Orientation and rates at arc lengths `s`."""
        x = s / self.length
        f, df, ddf = _fade_in(1 - x, self.cut, self.length)
        g, dg, ddg = _fade_in(x, self.cut, self.length)
        f, ddf = -f, -ddf  # the first leg runs backwards: its rate keeps its sign
        outer, inner = (
            scipy.spatial.transform.Rotation.from_rotvec(f[:, None] * self.before),
            scipy.spatial.transform.Rotation.from_rotvec(g[:, None] * self.after),
        )
        second = outer.apply(self.after)
        first_rate, second_rate = df[:, None] * self.before, dg[:, None] * second
        change = ddf[:, None] * self.before + ddg[:, None] * second + np.cross(first_rate, second_rate)
        return (outer * inner).as_matrix() @ self.corner, first_rate + second_rate, change


@dataclass(frozen=True, kw_only=True, eq=False)
class SplineTurn:
    """Smooth turn through orientations at given arc lengths, continuous in rate and its derivative."""

    knots: Array
    """Arc lengths, increasing, shape (K,)."""
    rotations: Array
    """Orientations there, shape (K, 3, 3)."""

    @cached_property
    def _spline(self) -> "scipy.spatial.transform.RotationSpline":
        return scipy.spatial.transform.RotationSpline(
            self.knots, scipy.spatial.transform.Rotation.from_matrix(self.rotations)
        )

    def at(self, s: Array) -> Turned:
        """Orientation and rates at arc lengths `s`; scipy gives the rates in the axes of the tool."""
        turn = self._spline(s)
        return turn.as_matrix(), turn.apply(self._spline(s, 1)), turn.apply(self._spline(s, 2))


Turning = EvenTurn | BlendedTurn | SplineTurn
"""Orientation of tool0 in the world as a function of arc length."""


def even_turn(start: Array, end: Array, length: float) -> EvenTurn:
    """Shortest turn from one orientation to another, shape (3, 3) each, over an arc length."""
    vector = scipy.spatial.transform.Rotation.from_matrix(end @ start.T).as_rotvec()
    return EvenTurn(start=start, rate=vector / length)


def _fade_in(x: Array, leg: float, length: float) -> tuple[Array, Array, Array]:
    """Quintic from 0 at rest at x = 0 to `leg` at unit rate at x = 1, and its derivatives by arc length."""
    a, b = 10 * leg - 4 * length, 7 * length - 15 * leg
    c = 6 * leg - 3 * length
    return (
        a * x**3 + b * x**4 + c * x**5,
        (3 * a * x**2 + 4 * b * x**3 + 5 * c * x**4) / length,
        (6 * a * x + 12 * b * x**2 + 20 * c * x**3) / length**2,
    )


SMOOTH = 1e-4
"""Largest change of the tangent [rad], and relative change of curvature, over which a path runs on without a rounded
corner; chosen: at 1 m/s a step in speed of 0.1 mm/s, far below what a drive can follow."""
SHARPEST = np.deg2rad(175.0)
"""Largest angle by which a rounded corner turns back [rad]; chosen: beyond it is a cusp, and the robot stops."""
SPENT = 1e-9
"""Share of a leg up to which what two corners leave of it is nothing; chosen: well above rounding."""
GRID = 16
"""Intervals in which each piece of a leg's curve is examined at least."""
GRID_STEP = 0.005
"""Longest interval in which a leg is examined [m, or s of joint motion]; chosen: over 5 mm the joint motion of an arm
hardly changes."""
GRID_TURN = 0.02
"""Largest angle by which the tool turns in an interval [rad]; chosen: an arm that moves its wrist much for it is near a
singularity."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Course:
    """Points along a path."""

    path: Derivatives
    """Position and its first three derivatives by arc length, shape (T, D) each."""
    turned: Turned | None
    """Orientation and its first two rates by arc length; None where there is none."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Leg:
    """A stretch of path between two targets, or the rounded corner between two legs."""

    curve: Curve
    speed: Speed | None
    """Programmed speed; None is as fast as the limits allow."""
    turning: Turning | None = None
    """Turning of the tool; None for a path of joints, or free orientation."""

    def at(self, s: Array) -> "Course":
        """Evaluate the leg at arc lengths `s` from its start, shape (T,)."""
        return Course(path=self.curve.at(s), turned=None if self.turning is None else self.turning.at(s))

    def grid(self) -> Array:
        """Arc lengths at which the leg is examined, from its start to its end, those of its knots among them."""
        knots = self.curve.knots
        pieces = []
        for start, end in itertools.pairwise(knots):
            turned = 0.0
            if self.turning is not None:
                rates = self.turning.at(np.linspace(start, end, GRID + 1))[1]
                turned = (end - start) * float(np.linalg.norm(rates, axis=1).max())
            count = max(GRID, int(np.ceil((end - start) / GRID_STEP)), int(np.ceil(turned / GRID_TURN)))
            pieces.append(np.linspace(start, end, count + 1)[:-1])
        return np.concatenate([*pieces, knots[-1:]])


@dataclass(frozen=True, kw_only=True, eq=False)
class Route:
    """Legs that follow each other without a gap, without a kink and without a jump in curvature."""

    legs: tuple[Leg, ...]

    @cached_property
    def ends(self) -> Array:
        """Arc length at the end of each leg, shape (L,)."""
        return np.cumsum([leg.curve.length for leg in self.legs])

    def at(self, s: Array) -> Course:
        """Evaluate the path at increasing arc lengths `s`, shape (T,)."""
        which = np.minimum(np.searchsorted(self.ends, s, side="right"), len(self.legs) - 1)
        starts = self.ends - [leg.curve.length for leg in self.legs]
        local = [(self.legs[i], s[which == i] - starts[i]) for i in np.unique(which)]
        return chain_courses([leg.at(np.clip(x, 0.0, leg.curve.length)) for leg, x in local])


def chain_courses(parts: Sequence[Course]) -> Course:
    """Chain points of several legs, one after the other; all of them turn the tool, or none."""
    p0, p1, p2, p3 = (np.concatenate(series) for series in zip(*(part.path for part in parts), strict=True))
    turns = [part.turned for part in parts if part.turned is not None]
    if not turns:
        return Course(path=(p0, p1, p2, p3), turned=None)
    r0, r1, r2 = (np.concatenate(series) for series in zip(*turns, strict=True))
    return Course(path=(p0, p1, p2, p3), turned=(r0, r1, r2))


def round_corners(legs: Sequence[Leg], zones: Sequence[float]) -> tuple[Route, Array]:
    """Join legs to a route with corners rounded within zones; return it with the arc lengths of targets, shape (L,).

    `zones` say how far before and after each corner the rounding may begin and end, along the path. Those that would
    overlap shrink to half of the shorter leg; of a leg that two corners use up nothing is left between them.
    """
    cuts = [
        0.0 if meets(before, after) else min(zone, 0.5 * before.curve.length, 0.5 * after.curve.length)
        for zone, before, after in zip(zones, legs, legs[1:], strict=False)
    ]
    trimmed = [_trim(leg, a, b) for leg, a, b in zip(legs, [0.0, *cuts], [*cuts, 0.0], strict=True)]
    chain, targets, length = [], [], 0.0
    for i, leg in enumerate(trimmed):
        if leg.curve.length > SPENT * legs[i].curve.length:
            chain.append(leg)
            length += leg.curve.length
        if i < len(cuts):
            corner = _corner(legs[i], legs[i + 1], leg, trimmed[i + 1], cuts[i]) if cuts[i] > 0 else None
            passed = corner.curve.length if corner else 0.0
            targets.append(length + 0.5 * passed)
            chain += [corner] if corner else []
            length += passed
    return Route(legs=tuple(chain)), np.array([*targets, length])


def meets(before: Leg, after: Leg) -> bool:
    """Tell if a leg continues the one before smoothly: in direction, curvature and turning."""
    _, t0, n0, _ = before.curve.at(np.array([before.curve.length]))
    _, t1, n1, _ = after.curve.at(np.array([0.0]))
    bend = float(max(np.linalg.norm(n0), np.linalg.norm(n1)))
    smooth = bool(np.linalg.norm(t0 - t1) <= SMOOTH and np.linalg.norm(n0 - n1) <= SMOOTH * bend)
    if before.turning is None or after.turning is None:
        return smooth
    w0, w1 = before.turning.at(np.array([before.curve.length]))[1], after.turning.at(np.array([0.0]))[1]
    rate = float(max(np.linalg.norm(w0), np.linalg.norm(w1)))
    return smooth and bool(np.linalg.norm(w0 - w1) <= SMOOTH * rate)


def corner_angle(before: Curve, after: Curve) -> float:
    """Angle [rad] between the directions in which one curve ends and the next one starts."""
    t0, t1 = before.at(np.array([before.length]))[1][0], after.at(np.array([0.0]))[1][0]
    return float(2 * np.arctan2(np.linalg.norm(t1 - t0), np.linalg.norm(t1 + t0)))


def _trim(leg: Leg, start: float, end: float) -> Leg:
    """Trim the first and last stretch off a leg."""
    if start == 0 and end == 0:
        return leg
    turning = leg.turning
    if isinstance(turning, EvenTurn):
        turning = EvenTurn(start=turning.at(np.array([start]))[0][0], rate=turning.rate)
    return replace(leg, curve=Part(curve=leg.curve, start=start, end=leg.curve.length - end), turning=turning)


def _corner(before: Leg, after: Leg, first: Leg, second: Leg, cut: float) -> Leg:
    """Rounded corner between the trimmed legs, at the lower of their speeds."""
    curve = blend(first.curve, second.curve)
    turning: Turning | None = None
    if isinstance(before.turning, EvenTurn) and isinstance(after.turning, EvenTurn):
        turning = BlendedTurn(
            corner=after.turning.start,
            before=before.turning.rate,
            after=after.turning.rate,
            cut=cut,
            length=curve.length,
        )
    elif before.turning is not None or after.turning is not None:
        raise FFGymError("A corner is rounded between legs that turn the tool evenly; stop before and after a spline.")
    return Leg(curve=curve, speed=slower(before.speed, after.speed), turning=turning)


def slower(first: Speed | None, second: Speed | None) -> Speed | None:
    """The lower of two programmed speeds, in each of its parts."""
    if first is None or second is None:
        return first or second
    parts = (field.name for field in fields(Speed))
    return Speed(**{name: min(getattr(first, name), getattr(second, name)) for name in parts})
