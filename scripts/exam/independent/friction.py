r"""Friction as an operator of the way travelled since the last step, not as a differential equation.

Surfaces have the strength :math:`g` that they bear at the present speed and load, and the described stiffness
:math:`\sigma_0` at rest; from one sliding direction to the other they follow

.. math:: F(x) = g - 2 g\, e^{-\sigma_0 x / g}
"""

from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from ffgym.core.types import Array, BoolArray

_LONGEST = 5.0
"""Way at which the last block slips, in ways in which the whole yields; chosen: 1 % of the stiffness is left."""

_BLOCKS = 24
"""Blocks in a contact."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Contact:
    """Friction before and after breakaway of (B, N) motors, by bristles or, where there are any, by blocks.

    Bristles yield little by little (Dahl 1968), integrated exactly along the way. Blocks on springs slip at a strength
    of their own each (generalised Maxwell slip); at rest they have slid against where they will move, and came back
    until the force was gone. The memory is the force of the bristles, and beside it that of each block: (B, N, 1 + M).

    Reference:
        Al-Bender, Lampaert, Swevers (2005), IEEE TAC 50(11).
    """

    stiffness: Array
    """Stiffness at rest, and of all blocks together when they turn back after sliding [N m/rad], shape (B, N)."""
    has_blocks: BoolArray
    """Where blocks rub, shape (B, N)."""

    @cached_property
    def shares(self) -> tuple[Array, Array]:
        """Share of each block in stiffness and strength, shape (M,) each; both add up to 1."""
        edge = np.linspace(0, _LONGEST, _BLOCKS)  # ways at which blocks slip, in those in which the whole yields
        holding = np.append(np.exp(-edge), 0.0)
        slipped = np.append(1 - (1 + edge) * np.exp(-edge), 1.0)
        return -np.diff(holding), np.diff(slipped)

    def at_rest(self, heading: Array, strength: Array) -> Array:
        """Memory without force of motors that will first move in the direction `heading`, +1 or -1, shape (B, N)."""
        bristles = np.zeros_like(strength)[..., None]
        if not self.has_blocks.any():
            return bristles
        slid = -(heading * strength)[..., None] * self.shares[1]
        back = heading * np.log(2.0) * strength / self.stiffness
        return np.concatenate([bristles, self._slip(slid, back, strength)], axis=-1)

    def moved(self, memory: Array, way: Array, strength: Array) -> tuple[Array, Array]:
        """Force [N m] and memory after a `way` [rad] in one direction, under a strength [N m]; shapes (B, N)."""
        end, before = np.sign(way) * strength, memory[..., 0]
        force = end + (before - end) * np.exp(-self.stiffness * np.abs(way) / strength)
        force = np.where(way == 0, before, force)
        if not self.has_blocks.any():
            return force, force[..., None]
        blocks = self._slip(memory[..., 1:], way, strength)
        return np.where(self.has_blocks, blocks.sum(axis=-1), force), np.concatenate(
            [force[..., None], blocks], axis=-1
        )

    def _slip(self, memory: Array, way: Array, strength: Array) -> Array:
        """Force of each block after a way."""
        stiff, strong = self.shares
        limit = strength[..., None] * strong
        force = memory + (2 * self.stiffness * way)[..., None] * stiff
        return np.minimum(np.maximum(force, -limit), limit)
