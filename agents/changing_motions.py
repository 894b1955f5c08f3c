r"""Stability of learning where every trial runs another motion, which thesis 7.2 leaves to future work.

Motion m has a map of its own (`ffgym.agents.stability`), so that trial k changes the weights of a joint by

.. math:: w_{k+1} = (I - \gamma L_{m(k)}) w_k + const, \qquad L_m = N_m B_m^T G_m B_m

Weights of splines that a motion does not meet stay. That every motion is stable by itself does not suffice: a product
of stable matrices may grow. Three figures tell, each a factor per trial:

    bound       max_m ||I - gamma L_m||, largest singular value: no order of motions grows faster
    worst       largest growth of orders that repeat after a few trials: this one is reached
    drawn       growth where the motion of each trial is drawn at random

A bound of 1 proves that learning stays bounded whatever the order: the distance of the weights to any others that learn
from the same trials cannot grow. For the plain gradient (3.16), N = I, and I - gamma B^T G B is symmetric where G = 1,
so that one norm serves all motions. The normalised update (3.17) has no such norm, as each motion divides by its own
sums.

Run it:

    ffgym train stability --changing
    ffgym train stability --changing --unnormalised --gamma 0.001

Departures from the source: none. Limits: those of `ffgym.agents.stability`.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import product
from typing import Self

import numpy as np

from ffgym.agents.bspline import BSplineNetwork
from ffgym.agents.stability import STABLE_GROWTH, LearningStability
from ffgym.agents.trials import Signal
from ffgym.core.errors import check_number
from ffgym.core.types import Array
from ffgym.paths import Reference
from ffgym.robot import RigidArm
from ffgym.simulation import RECORD_DT

LONGEST = 6
"""Trials after which an order repeats, at most; chosen."""
MOST_ORDERS = 300
"""Orders of one length that are tried, at most: a few seconds for 100 weights; chosen."""
TRIALS = 400
"""Trials of a drawn order; the first quarter does not count. Chosen: growth by 0.1 % a trial makes a factor of 1.3."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ChangingMotions:
    """Prediction of learning from M motions, one per trial in any order, joint by joint."""

    joints: tuple[str, ...]
    maps: tuple[Array, ...]
    """L of every motion for each joint, on the K splines that any motion meets, shape (M, K, K)."""

    @classmethod
    def of(
        cls,
        network: BSplineNetwork,
        arm: RigidArm,
        references: Sequence[Reference],
        *,
        signal: Signal = "u_p",
        record_dt: float = RECORD_DT,
    ) -> Self:
        """Predict the learning of `network` from one of `references` per trial; see `LearningStability.of`."""
        alone = [
            LearningStability.of(network, arm, [reference], signal=signal, record_dt=record_dt)
            for reference in references
        ]
        maps = []
        for joint in range(network.n_joints):
            own = [study.maps[joint] for study in alone]
            met = np.unique(np.concatenate([each.splines for each in own]))
            matrices = np.zeros((len(own), len(met), len(met)))
            for matrix, each in zip(matrices, own, strict=True):
                places = np.searchsorted(met, each.splines)
                matrix[np.ix_(places, places)] = each.average @ each.loss
            maps.append(matrices)
        return cls(joints=arm.robot.joints, maps=tuple(maps))

    def bound(self, rate: float) -> Array:
        """Compute the largest factor per trial in any order, of the length of the vector of weights, shape (N,)."""
        return np.array([np.linalg.norm(step, 2, axis=(1, 2)).max() for step in self._steps(rate)])

    @property
    def safe_rate(self) -> Array:
        """Largest rate with a bound up to STABLE_GROWTH: stable in any order, shape (N,); 0 if every rate may grow."""
        return np.array([_largest_safe(matrices) for matrices in self.maps])

    def worst(self, rate: float) -> tuple[Array, list[tuple[int, ...]]]:
        """Find the order of a few trials that grows most when it is repeated: factors per trial (N,), and orders."""
        found = [_worst_order(step) for step in self._steps(rate)]
        return np.array([growth for growth, _ in found]), [order for _, order in found]

    def drawn(self, rate: float, rng: np.random.Generator, trials: int = TRIALS) -> Array:
        """Compute the factor per trial where every motion is as likely in each trial, shape (N,)."""
        growth = []
        for step in self._steps(rate):
            weights, logs = rng.normal(size=step.shape[1]), []
            for motion in rng.integers(len(step), size=trials):
                weights = step[motion] @ weights
                length = np.linalg.norm(weights)
                logs.append(np.log(length))
                weights = weights / length
            growth.append(np.exp(np.mean(logs[trials // 4 :])))
        return np.array(growth)

    def _steps(self, rate: float) -> list[Array]:
        """Build I - rate L of every motion for each joint, (M, K, K) each."""
        check_number("learning rate", rate, low=0.0)
        return [np.eye(matrices.shape[1]) - rate * matrices for matrices in self.maps]


def _worst_order(step: Array) -> tuple[float, tuple[int, ...]]:
    """Find the repeated order of trials with steps (M, K, K) that grows most: its factor per trial, and the order."""
    worst: tuple[float, tuple[int, ...]] = (0.0, ())
    for length in range(1, LONGEST + 1):
        if len(step) ** length > MOST_ORDERS and length > 2:
            break
        for order in product(range(len(step)), repeat=length):
            others = [order[i:] + order[:i] for i in range(1, length)]
            if order in others or order > min(others, default=order):
                continue  # a shorter order repeated, or another beginning of one that is tried
            whole = reduce(lambda before, motion: step[motion] @ before, order, np.eye(step.shape[1]))
            growth = float(np.abs(np.linalg.eigvals(whole)).max() ** (1 / length))
            worst = max(worst, (growth, order), key=lambda each: each[0])
    return worst


def _largest_safe(matrices: Array) -> float:
    """Bisect for the largest rate at which no step grows; the norm is convex in the rate, and 1 at 0."""
    identity, low = np.eye(matrices.shape[1]), 0.0
    high = 4 / max(float(np.linalg.norm(matrices, 2, axis=(1, 2)).max()), 1e-12)  # there, a step is 3 at least
    for _ in range(40):
        rate = (low + high) / 2
        safe = np.linalg.norm(identity - rate * matrices, 2, axis=(1, 2)).max() <= STABLE_GROWTH
        low, high = (rate, high) if safe else (low, rate)
    return low
