r"""Friction as an operator of the way travelled since the last step, not as a differential equation.

Both members have the strength :math:`g` that surfaces bear at the present speed and load, and the described stiffness
:math:`\sigma_0` at rest; from one sliding direction to the other both follow

.. math:: F(x) = g - 2 g\, e^{-\sigma_0 x / g}
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from ffgym.types import Array


class Contact(ABC):
    """Friction before and after breakaway, for (B, N) motors at once."""

    @abstractmethod
    def at_rest(self, shape: tuple[int, ...]) -> Array:
        """Memory without force, for motors of `shape` (B, N)."""

    @abstractmethod
    def moved(self, memory: Array, way: Array, strength: Array) -> tuple[Array, Array]:
        """Force [N m] and memory after a `way` [rad] in one direction, under a strength [N m]; shapes (B, N)."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Bristles(Contact):
    """Bristles that yield little by little (Dahl 1968), integrated exactly along the way."""

    stiffness: Array
    """At rest [N m/rad], shape (B, N)."""

    def at_rest(self, shape: tuple[int, ...]) -> Array:
        """See base class; memory is the force."""
        return np.zeros(shape)

    def moved(self, memory: Array, way: Array, strength: Array) -> tuple[Array, Array]:
        """See base class."""
        end = np.sign(way) * strength
        force = end + (memory - end) * np.exp(-self.stiffness * np.abs(way) / strength)
        force = np.where(way == 0, memory, force)
        return force, force


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Blocks(Contact):
    """Blocks on springs, each of which slips at a strength of its own (generalised Maxwell slip).

    Reference:
        Al-Bender, Lampaert, Swevers (2005), IEEE TAC 50(11).
    """

    stiffness: Array
    """Of the whole when it turns back after sliding [N m/rad], shape (B, N); all springs together have as much."""
    count: int = 10
    """Blocks."""

    @cached_property
    def shares(self) -> tuple[Array, Array]:
        """Share of each block in stiffness and strength, shape (count,) each; both add up to 1."""
        edge = -np.log(np.linspace(1, 0, self.count + 1)[:-1])  # equal shares of stiffness, in ways of yielding
        below = np.append(1 - (1 + edge) * np.exp(-edge), 1.0)
        return np.full(self.count, 1 / self.count), np.diff(below)

    def at_rest(self, shape: tuple[int, ...]) -> Array:
        """See base class; memory is the force of each block, shape (B, N, count)."""
        return np.zeros((*shape, self.count))

    def moved(self, memory: Array, way: Array, strength: Array) -> tuple[Array, Array]:
        """See base class."""
        stiff, strong = self.shares
        limit = strength[..., None] * strong
        force = memory + (2 * self.stiffness * way)[..., None] * stiff
        force = np.minimum(np.maximum(force, -limit), limit)
        return force.sum(axis=-1), force
