"""How the tool turns along a curve: orientation, and its first two derivatives by arc length."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np
from scipy.spatial.transform import Rotation, RotationSpline

from ffgym.core.types import Array

Turned = tuple[Array, Array, Array]
"""Orientation (T, 3, 3), its rate by arc length and the rate of that, in world axes [rad/m, rad/m^2], (T, 3)."""


class Turning(ABC):
    """Orientation of tool0 in the world as a function of arc length."""

    @abstractmethod
    def at(self, s: Array) -> Turned:
        """Orientation and rates at arc lengths `s`, shape (T,)."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class EvenTurn(Turning):
    """The tool turns about one axis of the world at a constant rate; a rate of zero keeps the orientation."""

    start: Array
    """Orientation at s = 0, shape (3, 3)."""
    rate: Array
    """Rotation vector by arc length, world axes [rad/m], shape (3,)."""

    def at(self, s: Array) -> Turned:
        """Orientation and rates at arc lengths `s`."""
        rotation = Rotation.from_rotvec(s[:, None] * self.rate).as_matrix() @ self.start
        still = np.zeros((len(s), 3))
        return rotation, still + self.rate, still


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class BlendedTurn(Turning):
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
        outer, inner = Rotation.from_rotvec(f[:, None] * self.before), Rotation.from_rotvec(g[:, None] * self.after)
        second = outer.apply(self.after)
        first_rate, second_rate = df[:, None] * self.before, dg[:, None] * second
        change = ddf[:, None] * self.before + ddg[:, None] * second + np.cross(first_rate, second_rate)
        return (outer * inner).as_matrix() @ self.corner, first_rate + second_rate, change


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SplineTurn(Turning):
    """Smooth turn through orientations at given arc lengths, continuous in rate and its derivative."""

    knots: Array
    """Arc lengths, increasing, shape (K,)."""
    rotations: Array
    """Orientations there, shape (K, 3, 3)."""

    @cached_property
    def _spline(self) -> RotationSpline:
        return RotationSpline(self.knots, Rotation.from_matrix(self.rotations))

    def at(self, s: Array) -> Turned:
        """Orientation and rates at arc lengths `s`; scipy gives the rates in the axes of the tool."""
        turn = self._spline(s)
        return turn.as_matrix(), turn.apply(self._spline(s, 1)), turn.apply(self._spline(s, 2))


def even_turn(start: Array, end: Array, length: float) -> EvenTurn:
    """Shortest turn from one orientation to another, shape (3, 3) each, over an arc length."""
    vector = Rotation.from_matrix(end @ start.T).as_rotvec()
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
