r"""Gauss-Newton in a trust region: the one loop behind all fits to a log.

A point is a machine with some values of what is fitted, replayed, with slopes about it. Each step minimises the energy
that slopes promise within a reach of every unknown, and is taken if the replay of the machine that it leads to agrees
that less is left:

.. math:: \min_d\ |r - J d|^2 + |x + d|_P^2, \quad |d_i| \le \Delta

Else it was too long: the reach becomes a third of it. What is fitted, and in which units, is the matter of a `Slope`.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

from ffgym.core.types import Array

P = TypeVar("P")

_SHRINKS, _GROWS = 1 / 3, 2.0
"""Factors of the reach after a step that makes things worse, and after one that does not."""

_ALMOST = 0.99
"""Share of the reach below which a step was not held back by it."""


class Slope(ABC, Generic[P]):
    """Unknowns of a fit: what a point of them costs, and where slopes lead from it."""

    @abstractmethod
    def cost(self, point: P) -> float:
        """Return the energy that a point leaves, with what its priors cost."""

    @abstractmethod
    def step(self, point: P, reach: float) -> Array:
        """Return the change of all unknowns that slopes about a point ask for, none by more than `reach`."""

    @abstractmethod
    def move(self, point: P, step: Array) -> P | None:
        """Replay the machine after a step; None if no machine can be so."""

    @abstractmethod
    def renew(self, point: P, *, is_last: bool) -> P | None:
        """Compute slopes about a point that a step led to, unless it is the last and needs none.

        None if there are none; the fit then ends at the point before.
        """

    def length(self, step: Array) -> float:
        """Return the length of a step, which the reach bounds."""
        return float(np.max(np.abs(step), initial=0.0))

    def is_hopeless(self, point: P) -> bool:
        """Tell whether slopes about a point say that going on leads nowhere."""
        return False


@dataclass(frozen=True, kw_only=True)
class Steps:
    """Bounds on the steps of a fit, and when it ends."""

    most: int
    """Steps that are taken at most."""
    least_reach: float
    """Reach below which a fit has come to rest, > 0."""
    reach: float = np.inf
    """Longest change of an unknown in one step, in its own unit."""
    gain: float = 0.0
    """Relative gain of a step below which another is not worth its replays."""
    rest: float = np.inf
    """Change of all unknowns below which such a step is the last."""


def descend(slope: Slope[P], start: P, steps: Steps) -> P | None:
    """Go down from a point with slopes; None if that is hopeless."""
    now, reach = start, steps.reach
    for taken in range(1, steps.most + 1):
        there, length = None, 0.0
        # shorten the step until it leads down
        while reach >= steps.least_reach:
            step = slope.step(now, reach)
            there, length = slope.move(now, step), slope.length(step)
            if there is not None and slope.cost(there) < slope.cost(now):
                break
            there, reach = None, min(reach, length) * _SHRINKS
        if there is None:
            return now
        # slopes anew, and whether they are worth another step
        is_short = length < min(_ALMOST * reach, steps.rest)
        is_last = taken == steps.most or (slope.cost(there) > (1 - steps.gain) * slope.cost(now) and is_short)
        then = slope.renew(there, is_last=is_last)
        if then is None or is_last:
            return then or now
        now, reach = then, min(_GROWS * reach, steps.reach)
        if slope.is_hopeless(now):
            return None
    return now
