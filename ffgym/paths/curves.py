"""Curves by arc length, with derivatives to third order: lines, arcs, corner blends and splines; `timing` adds time.

A curve lives in any number of dimensions: positions of the tool centre point [m], or joint positions, each in units of
its joint's largest speed, so that a joint curve's arc length is a time [s].
"""

import itertools
from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np
import scipy

from ffgym.core.errors import FFGymError, check_number, check_shape
from ffgym.core.types import Array

Derivatives = tuple[Array, Array, Array, Array]
"""Position and its first three derivatives by arc length, each of shape (T, D)."""

SAME = 1e-7
"""Distance [m] and angle [rad] below which two points and two orientations count as one; chosen: far below what an arm
repeats, and far above the 1e-10 m that inverse kinematics leave where a path starts."""
STRAIGHT = 1e-6
"""Sine of the angle below which three points count as lying on a line; chosen: over 1 m such an arc is less than 1 um
beside the line, and what inverse kinematics leave at the start of an arc of 1 mm turns it by less."""


class Curve(ABC):
    """A curve with three bounded derivatives by arc length s."""

    @property
    @abstractmethod
    def length(self) -> float:
        """Arc length [m, or s in joint space], > 0."""

    @property
    def knots(self) -> Array:
        """Arc lengths at which one formula ends and the next begins, increasing, with both ends, shape (K,)."""
        return np.array([0.0, self.length])

    @abstractmethod
    def at(self, s: Array) -> Derivatives:
        """Position and derivatives at arc lengths `s` within [0, length], shape (T,)."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Line(Curve):
    """Straight line."""

    start: Array
    """Shape (D,)."""
    end: Array
    """Shape (D,), not `start`."""

    def __post_init__(self) -> None:
        if not self.length > 0:
            raise FFGymError(f"A line from {self.start.tolist()} to {self.end.tolist()} has no direction.")

    @property
    def length(self) -> float:
        """Distance of the two ends."""
        return float(np.linalg.norm(self.end - self.start))

    def at(self, s: Array) -> Derivatives:
        """Position, unit tangent, and zeros."""
        share = (s / self.length)[:, None]
        tangent = (self.end - self.start) / self.length
        still = np.zeros((len(s), len(tangent)))
        return self.start * (1 - share) + self.end * share, still + tangent, still, still


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Arc(Curve):
    """Arc of a circle, which starts at centre + radius * first and turns towards `second`."""

    centre: Array
    """Shape (D,)."""
    first: Array
    """Unit vector from the centre to the start, shape (D,)."""
    second: Array
    """Unit tangent at the start, across `first`, shape (D,)."""
    radius: float
    """> 0."""
    angle: float
    """Angle of the arc [rad], > 0; 2 pi is a circle."""

    @property
    def length(self) -> float:
        """Radius times angle."""
        return self.radius * self.angle

    def at(self, s: Array) -> Derivatives:
        """Derivatives of the circle: each is the one before, a quarter turn on, divided by the radius."""
        angle = (s / self.radius)[:, None]
        outward = np.cos(angle) * self.first + np.sin(angle) * self.second
        along = np.cos(angle) * self.second - np.sin(angle) * self.first
        r = self.radius
        return self.centre + r * outward, along, -outward / r, -along / r**2


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Still(Curve):
    """No curve at all: a point at which the tool turns. Its length is the angle that it turns [rad]."""

    point: Array
    """Shape (D,)."""
    angle: float
    """[rad], > 0."""

    @property
    def length(self) -> float:
        """The angle."""
        return self.angle

    def at(self, s: Array) -> Derivatives:
        """The point, and zeros."""
        still = np.zeros((len(s), len(self.point)))
        return still + self.point, still, still, still


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Part(Curve):
    """Part of a curve between two arc lengths."""

    curve: Curve
    start: float
    """Arc length at which it starts, >= 0."""
    end: float
    """Arc length at which it ends, > start."""

    @property
    def length(self) -> float:
        """Arc length in between."""
        return self.end - self.start

    def at(self, s: Array) -> Derivatives:
        """Position and derivatives, of the whole curve."""
        return self.curve.at(self.start + s)


def arc_through(start: Array, via: Array, end: Array) -> Arc:
    """Arc from `start` through `via` to `end`, points of shape (3,)."""
    start, via, end = (check_shape(name, p, (3,)) for name, p in (("start", start), ("via", via), ("end", end)))
    a, b = via - start, end - start
    normal = np.cross(a, b)
    area, sides = float(np.linalg.norm(normal)), [float(np.linalg.norm(side)) for side in (a, b, via - end)]
    if min(sides) <= SAME or area <= STRAIGHT * sides[0] * sides[1]:
        points = ", ".join(str(p.round(9).tolist()) for p in (start, via, end))
        raise FFGymError(
            f"The points {points} m lie on a line or coincide, so that no arc runs through them. Move one of them, use "
            f"a line, or make a circle of two arcs."
        )
    # centre of the circle through three points, from the sides that leave `start`
    centre = start + np.cross(a @ a * b - b @ b * a, normal) / (2 * area**2)
    # angle in (0, 2 pi] from one arm to the other about the normal
    first, last = start - centre, end - centre
    angle = float(np.arctan2(float(np.cross(first, last) @ normal) / float(np.linalg.norm(normal)), first @ last))
    return arc_about(centre, start, normal, angle if angle > 0 else angle + 2 * np.pi)


def arc_about(centre: Array, start: Array, normal: Array, angle: float) -> Arc:
    """Arc about an axis through `centre` (3,) along `normal` (3,), of any length, by the right hand over `angle`.

    It begins at `start` (3,), in the plane of the centre and not on the axis; an angle of 2 pi [rad] is a full circle.
    """
    angle = check_number("angle of an arc", angle, unit="rad", low=0.0, open_low=True)
    axis = normal / np.linalg.norm(normal)
    arm = start - centre
    height, radius = float(arm @ axis), float(np.linalg.norm(arm))
    if not abs(height) <= 1e-6 * radius or radius == 0:
        raise FFGymError(
            f"An arc about {centre.tolist()} m cannot start at {start.tolist()} m: the start must lie in the plane of "
            f"the arc and beside its centre, but it is {height:.3g} m above the plane, {radius:.3g} m from the centre."
        )
    first = (arm - height * axis) / np.linalg.norm(arm - height * axis)
    return Arc(centre=start - radius * first, first=first, second=np.cross(axis, first), radius=radius, angle=angle)


_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(12)
_PIECES = 16
"""Pieces of each polynomial between which arc length is tabled; with 12 nodes each its error is below 1e-12."""
_STEPS = 12
"""Newton steps from arc length to parameter at most: 3 or 4 are enough, the rest are for very uneven speed."""
_MISS = 1e-9
"""Error of arc length, as a share of the whole, after which one more Newton step, which squares it, leaves rounding."""


SHORTEST = 1e-15
"""Length of a piece of a curve, in m or rad, that rounding of positions leaves nothing of."""
CUSP = 0.01
"""Speed by its parameter, which is 1 on average, below which a spline counts as turning on the spot."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class PolynomialCurve(Curve):
    """Piecewise polynomial curve, twice continuously differentiable, whose speed by its parameter is nowhere zero."""

    polynomial: "scipy.interpolate.PPoly"
    """Position as a function of any parameter u, shape (D,)."""

    @cached_property
    def _slopes(self) -> "tuple[scipy.interpolate.PPoly, scipy.interpolate.PPoly, scipy.interpolate.PPoly]":
        return self.polynomial.derivative(1), self.polynomial.derivative(2), self.polynomial.derivative(3)

    @cached_property
    def _table(self) -> tuple[Array, Array]:
        """Parameters and the arc lengths that lead to them."""
        ends = self.polynomial.x
        u = np.concatenate([np.linspace(a, b, _PIECES, endpoint=False) for a, b in itertools.pairwise(ends)])
        u = np.append(u, ends[-1])
        lengths = self._length_between(u[:-1], u[1:])
        if not lengths.min() > SHORTEST:
            raise FFGymError(
                f"A piece of a curve is {lengths.min():g} long, must be more than {SHORTEST:g}. Is a zone, or a "
                f"distance between points, in another unit?"
            )
        return u, np.concatenate([[0.0], np.cumsum(lengths)])

    def _length_between(self, start: Array, end: Array) -> Array:
        """Arc length from `start` to `end`, parameters of shape (T,) within one polynomial each."""
        half = 0.5 * (end - start)
        u = (0.5 * (start + end))[:, None] + half[:, None] * _NODES
        speed = np.linalg.norm(self._slopes[0](u), axis=-1)
        return half * (speed * _WEIGHTS).sum(axis=1)

    @property
    def length(self) -> float:
        """Arc length of the whole."""
        return float(self._table[1][-1])

    @property
    def knots(self) -> Array:
        """Arc lengths at which one polynomial ends and the next begins, with both ends."""
        return self._table[1][::_PIECES]

    def _parameter(self, s: Array) -> Array:
        """Parameter u at arc lengths `s`: from the table, then by Newton's method within the piece."""
        u_table, s_table = self._table
        piece = np.clip(np.searchsorted(s_table, s, side="right") - 1, 0, len(u_table) - 2)
        low, high = u_table[piece], u_table[piece + 1]
        start = s_table[piece]
        u = low + (high - low) * (s - start) / (s_table[piece + 1] - start)
        done = np.zeros(len(u), dtype=np.bool_)  # row by row, so that no row's bits depend on its neighbours
        for _ in range(_STEPS):
            miss = self._length_between(low, u) - (s - start)
            step = miss / np.linalg.norm(self._slopes[0](u), axis=-1)
            u = np.where(done, u, np.clip(u - step, low, high))
            done |= np.abs(miss) <= _MISS * s_table[-1]
            if done.all():
                break
        return u

    def at(self, s: Array) -> Derivatives:
        """Position and derivatives by arc length, by the chain rule."""
        u = self._parameter(np.asarray(s, dtype=np.float64))
        first, second, third = (slope(u) for slope in self._slopes)
        speed = np.linalg.norm(first, axis=1)
        rate = (first * second).sum(axis=1) / speed
        change = ((second * second).sum(axis=1) + (first * third).sum(axis=1) - rate**2) / speed
        u1, u2, u3 = 1 / speed, -rate / speed**3, (3 * rate**2 - change * speed) / speed**5
        u1, u2, u3 = u1[:, None], u2[:, None], u3[:, None]
        return (
            self.polynomial(u),
            first * u1,
            second * u1**2 + first * u2,
            third * u1**3 + 3 * second * u1 * u2 + first * u3,
        )


def blend(before: Curve, after: Curve) -> PolynomialCurve:
    """Quintic from the end of one curve to the start of another that meets both in tangent and curvature.

    The parameter's speed at both ends is the length of the chord: it keeps the curvature of a right-angled corner
    within 4 % of the least that a quintic can have, and shrinks for sharp corners, where a longer one would bulge.
    """
    p0, t0, n0, _ = (part[0] for part in before.at(np.array([before.length])))
    p1, t1, n1, _ = (part[0] for part in after.at(np.array([0.0])))
    chord = float(np.linalg.norm(p1 - p0))
    quintic = scipy.interpolate.BPoly.from_derivatives(
        [0.0, 1.0], [[p0, chord * t0, chord**2 * n0], [p1, chord * t1, chord**2 * n1]]
    )
    return PolynomialCurve(polynomial=scipy.interpolate.PPoly.from_bernstein_basis(quintic))


def spline_through(points: Array, *, closed: bool = False) -> PolynomialCurve:
    """Cubic spline through points (K, D), K >= 2, that is continuous in tangent and curvature.

    The parameter is the chord length. At the ends the curvature is zero; a closed spline joins itself smoothly.
    """
    chords = np.linalg.norm(np.diff(points, axis=0), axis=1)
    if len(points) < 2 or np.any(chords <= 0):
        same = int(np.argmin(chords)) + 2 if len(points) > 1 else 1
        raise FFGymError(f"A spline needs two or more points, each apart from the one before; see point {same}.")
    if closed and len(points) < 4:
        raise FFGymError(f"A closed spline needs at least 4 points, the last equal to the first, got {len(points)}.")
    if closed and not np.allclose(points[0], points[-1], rtol=0, atol=1e-9):
        raise FFGymError("A closed spline must end at its first point.")
    u = np.concatenate([[0.0], np.cumsum(chords)])
    if closed:
        points = np.vstack([points[:-1], points[:1]])
    spline = scipy.interpolate.CubicSpline(u, points, bc_type="periodic" if closed else "natural")
    # nowhere may it turn on the spot, where it would have no direction
    slope = spline.derivative()
    u = np.concatenate([np.linspace(a, b, _PIECES, endpoint=False) for a, b in itertools.pairwise(spline.x)])
    slowest = int(np.argmin(np.linalg.norm(slope(u), axis=1)))
    around = u[max(slowest - 1, 0)], u[min(slowest + 1, len(u) - 1)]
    found = scipy.optimize.minimize_scalar(lambda x: float(np.linalg.norm(slope(x))), bounds=around, method="bounded")
    if found.fun < CUSP:
        point = int(np.argmin(np.abs(spline.x - found.x))) + 1
        raise FFGymError(
            f"The spline turns back on the spot near point {point}; end it there, or move the point aside."
        )
    return PolynomialCurve(polynomial=spline)
