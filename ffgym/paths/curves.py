"""Curves by arc length: straight lines and arcs, with derivatives to third order. Time comes later, in `timing`.

A curve lives in any number of dimensions: positions of the tool centre point [m], or joint positions, each in units of
its joint's largest speed, so that a joint curve's arc length is a time [s].
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import final

import numpy as np

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
    """What the arc spans [rad], > 0; 2 pi is a circle."""

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
    """What lies between two arc lengths of a curve."""

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
    """Arc from `start` through `via` to `end`, points of shape (3,).

    Raises:
        FFGymError: if the points lie on a line, or two are the same.
    """
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
    return arc_about(centre, start, normal, _angle_between(start - centre, end - centre, normal))


def arc_about(centre: Array, start: Array, normal: Array, angle: float) -> Arc:
    """Arc about an axis through `centre` along `normal`, from `start`, which lies in the plane of the centre.

    Args:
        centre: shape (3,) [m].
        start: shape (3,) [m], not on the axis.
        normal: shape (3,), any length; the arc turns about it by the right hand.
        angle: [rad], > 0; 2 pi is a full circle.

    Raises:
        FFGymError: if the start lies outside the plane or in the centre.
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


def _angle_between(first: Array, second: Array, normal: Array) -> float:
    """Angle [rad] in (0, 2 pi] from one arm to the other about `normal`."""
    sine = float(np.cross(first, second) @ normal) / float(np.linalg.norm(normal))
    angle = float(np.arctan2(sine, first @ second))
    return angle if angle > 0 else angle + 2 * np.pi
