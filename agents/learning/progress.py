"""How far learning has come: mean squares of every trial, the weights to try next, the best so far, joints done."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ffgym.agents.common.network import Network
from ffgym.agents.common.trials import Lesson
from ffgym.core.types import Array, BoolArray, IntArray


@dataclass(frozen=True, kw_only=True, eq=False)
class Learning:
    """Learning after K trials; every trial makes a new one."""

    network: Network
    """To be tried next."""
    best: Network
    """On each joint the weights that had the lowest mean square error."""
    error: Array
    """Mean square motor position error of each trial and motion [rad^2], shape (K, M, N), thesis (5.6)."""
    signal: Array
    """Mean square of the learning signal of each trial and motion [(N m)^2], shape (K, M, N)."""
    best_trial: IntArray
    """Trial whose weights `best` has, shape (N,)."""
    stale: IntArray
    """Trials in a row that did not improve, shape (N,)."""
    locked: BoolArray
    """Joints that are done and keep their best weights, shape (N,)."""

    @classmethod
    def begin(cls, network: Network, n_motions: int) -> "Learning":
        """Before the first trial with M motions."""
        n = network.n_joints
        return cls(
            network=network,
            best=network,
            error=np.zeros((0, n_motions, n)),
            signal=np.zeros((0, n_motions, n)),
            best_trial=np.zeros(n, dtype=np.intp),
            stale=np.zeros(n, dtype=np.intp),
            locked=np.zeros(n, dtype=np.bool_),
        )

    @property
    def trials(self) -> int:
        """Number of trials K."""
        return len(self.error)

    def after(self, lessons: Sequence[Lesson], *, rate: float, tolerance: float, patience: int) -> "Learning":
        """After a trial of `network` that gave `lessons`; see `ffgym.agents.learning.lffc` for the rule."""
        error = np.concatenate([self.error, [[_mean_square(lesson, lesson.error) for lesson in lessons]]])
        signal = np.concatenate([self.signal, [[_mean_square(lesson, lesson.signal) for lesson in lessons]]])
        cost = relative(error)
        is_best = ~self.locked & (cost[-1] <= cost.min(axis=0))
        best = self.best.merged(self.network, is_best)
        stale = np.where(_fell(cost, tolerance) & _fell(relative(signal), tolerance), 0, self.stale + 1)
        locked = self.locked | (stale >= patience)
        return Learning(
            network=self.network.adapted(lessons, rate).merged(best, locked),
            best=best,
            error=error,
            signal=signal,
            best_trial=np.where(is_best, self.trials, self.best_trial),
            stale=stale,
            locked=locked,
        )


def relative(mean_square: Array) -> Array:
    """Mean squares (K, M, N) over those of the first trial, averaged over motions, shape (K, N).

    A joint that had none at first, as one that never moves, has 0.
    """
    first = mean_square[:1]
    return np.asarray(np.divide(mean_square, first, out=np.zeros_like(mean_square), where=first > 0).mean(axis=1))


def _mean_square(lesson: Lesson, values: Array) -> Array:
    """Of values (T, N) of a lesson without standstill, shape (N,)."""
    return np.asarray(np.mean(values[lesson.moving] ** 2, axis=0))


def _fell(history: Array, tolerance: float) -> BoolArray:
    """Where the last row of `history` (K, N) is lower than the one before by more than a share of it, thesis (5.7)."""
    if len(history) < 2:
        return np.ones(history.shape[1], dtype=np.bool_)
    return np.asarray(history[-1] < (1 - tolerance) * history[-2])
