r"""Friction as an operator of the way travelled since the last step, not as a differential equation.

Members have the strength :math:`g` that surfaces bear at the present speed and load, and the described stiffness
:math:`\sigma_0` at rest; from one sliding direction to the other they follow

.. math:: F(x) = g - 2 g\, e^{-\sigma_0 x / g}
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from ffgym.core.types import Array, BoolArray

_LONGEST = 5.0
"""Way at which the last block slips, in ways in which the whole yields; chosen: 1 % of the stiffness is left."""


class Contact(ABC):
    """Friction before and after breakaway, for (B, N) motors at once."""

    @abstractmethod
    def at_rest(self, heading: Array, strength: Array) -> Array:
        """Memory without force of motors that will first move in the direction `heading`, +1 or -1, shape (B, N)."""

    @abstractmethod
    def moved(self, memory: Array, way: Array, strength: Array) -> tuple[Array, Array]:
        """Force [N m] and memory after a `way` [rad] in one direction, under a strength [N m]; shapes (B, N)."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Bristles(Contact):
    """Bristles that yield little by little (Dahl 1968), integrated exactly along the way."""

    stiffness: Array
    """At rest [N m/rad], shape (B, N)."""

    def at_rest(self, heading: Array, strength: Array) -> Array:
        """See base class; memory is the force."""
        return np.zeros_like(strength)

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

    At rest they have slid against where they will move, and came back until the force was gone.

    Reference:
        Al-Bender, Lampaert, Swevers (2005), IEEE TAC 50(11).
    """

    stiffness: Array
    """Of the whole when it turns back after sliding [N m/rad], shape (B, N); all springs together have as much."""
    count: int = 24
    """Blocks."""

    @cached_property
    def shares(self) -> tuple[Array, Array]:
        """Share of each block in stiffness and strength, shape (count,) each; both add up to 1."""
        edge = np.linspace(0, _LONGEST, self.count)  # ways at which blocks slip, in those in which the whole yields
        holding = np.append(np.exp(-edge), 0.0)
        slipped = np.append(1 - (1 + edge) * np.exp(-edge), 1.0)
        return -np.diff(holding), np.diff(slipped)

    def at_rest(self, heading: Array, strength: Array) -> Array:
        """See base class; memory is the force of each block, shape (B, N, count)."""
        slid = -(heading * strength)[..., None] * self.shares[1]
        back = heading * np.log(2.0) * strength / self.stiffness
        _, memory = self.moved(slid, back, strength)
        return np.asarray(memory)

    def moved(self, memory: Array, way: Array, strength: Array) -> tuple[Array, Array]:
        """See base class."""
        stiff, strong = self.shares
        limit = strength[..., None] * strong
        force = memory + (2 * self.stiffness * way)[..., None] * stiff
        force = np.minimum(np.maximum(force, -limit), limit)
        return force.sum(axis=-1), force


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Either(Contact):
    """Blocks in some joints, bristles in the others."""

    stiffness: Array
    """[N m/rad], shape (B, N)."""
    has_blocks: BoolArray
    """Shape (B, N)."""

    @cached_property
    def _members(self) -> tuple[Bristles, Blocks]:
        return Bristles(stiffness=self.stiffness), Blocks(stiffness=self.stiffness)

    def at_rest(self, heading: Array, strength: Array) -> Array:
        """See base class; memories of both, those of bristles first."""
        bristles, blocks = (member.at_rest(heading, strength) for member in self._members)
        return np.concatenate([bristles[..., None], blocks], axis=-1)

    def moved(self, memory: Array, way: Array, strength: Array) -> tuple[Array, Array]:
        """See base class."""
        bristles, blocks = self._members
        smooth, kept = bristles.moved(memory[..., 0], way, strength)
        stepped, slipped = blocks.moved(memory[..., 1:], way, strength)
        return np.where(self.has_blocks, stepped, smooth), np.concatenate([kept[..., None], slipped], axis=-1)
