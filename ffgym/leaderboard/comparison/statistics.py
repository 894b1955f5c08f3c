"""Interquartile means and their intervals by resampling seeds and plants; a stopped robot is the worst.

Departs from Agarwal et al. in two points, both because intervals would otherwise be too narrow, so that rows that do
not differ would get different ranks (tested: coverage):

- They draw seeds anew in every task. Here one training serves all cells, and a plant that is hard is hard in all
  cells, so a resample takes the same seeds and plants in every cell.
- Percentiles of so few seeds reach less far than they should; the expanded percentiles of Hesterberg do.

References:
    Agarwal, Schwarzer, Castro, Courville, Bellemare (2021), Deep Reinforcement Learning at the Edge of the
    Statistical Precipice, NeurIPS: interquartile mean, stratified bootstrap.
    Owen (2007), The pigeonhole bootstrap, Annals of Applied Statistics 1(2): two crossed factors, each resampled.
    Hesterberg (2015), What Teachers Should Know About the Bootstrap, The American Statistician 69(4), section 5.3.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import cast
from zlib import crc32

import numpy as np
import scipy

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array, IntArray

TRIM = 0.25
"""Share of values that an interquartile mean leaves out at either end."""
CONFIDENCE = 0.95
"""Confidence of every interval."""
RESAMPLES = 2000
"""Resamples of a row. Chosen: with other random numbers the ends of an interval scatter by less than a tenth of its
length (standard deviation, of means over 5 seeds, over 20 plants, and over both)."""

_SEED = 20210830
"""First number of the seeds of all resamples; chosen: the day that the paper appeared."""
_CHUNK = 500_000
"""Weights that are held at once; chosen to stay within the cache of a processor."""


@dataclass(frozen=True)
class Interval:
    """Interval that holds the true value in CONFIDENCE of all experiments; ends may be infinite."""

    low: float
    high: float

    def includes(self, value: float) -> bool:
        """Check that a value is in it, ends included."""
        return self.low <= value <= self.high


@dataclass(frozen=True, kw_only=True, eq=False)
class Resamples:
    """Counts of each of S seeds and each of P plants in each of R resamples."""

    seeds: IntArray
    """Counts of seeds, shape (R, S)."""
    plants: IntArray
    """Counts of plants, shape (R, P)."""

    @property
    def levels(self) -> int:
        """Fewest seeds or plants of a factor that has more than one; 1 without randomness."""
        return min((part.shape[1] for part in (self.seeds, self.plants) if part.shape[1] > 1), default=1)


@lru_cache(maxsize=64)
def draw_resamples(name: str, n_seeds: int, n_plants: int, count: int = RESAMPLES) -> Resamples:
    """Draw the resamples of a row.

    Rows of any name share the plants of a resample, so that differences between rows are paired by plant; seeds of two
    rows are independent trainings, and are drawn independently. The same name gives the same resamples.
    """
    return Resamples(
        seeds=_draw(n_seeds, count, np.random.default_rng([_SEED, 1, crc32(name.encode())])),
        plants=_draw(n_plants, count, np.random.default_rng([_SEED, 2])),
    )


def interquartile_mean(values: Array) -> float:
    """Compute the mean without the lowest and the highest quarter; NaN counts as the worst, infinity."""
    flat = np.sort(_worst(values), axis=None)
    if not len(flat):
        raise FFGymError("An interquartile mean needs at least one value, got none.")
    cut = int(TRIM * len(flat))
    return float(flat[cut : len(flat) - cut].mean())


def resample_means(values: Array, by: Resamples) -> Array:
    """Compute the mean of all values, shape (S, P, C), in every resample, shape (R,)."""
    each = _worst(values).mean(axis=-1)
    stopped = np.isinf(each)
    sums = _sum(np.where(stopped, 0.0, each), by) / each.size
    return np.where(_sum(stopped.astype(float), by) > 0, np.inf, sums)


def resample_iqms(values: Array, by: Resamples) -> Array:
    """Compute the interquartile mean of all values, shape (S, P, C), in every resample, shape (R,).

    E_i counts the values of a resample among the first i of all in ascending order. The sum between the quarters is
    then a sum by parts: sum (c_i - c_(i-1)) v_i with c = E, clipped to the range between the quarters.
    """
    flat = _worst(values).ravel()
    order = np.argsort(flat, kind="stable")
    n, finite = len(flat), int(np.isfinite(flat).sum())
    low, high = int(TRIM * n), n - int(TRIM * n)
    if not finite:
        return np.full(len(by.seeds), np.inf)
    # seed and plant of each value, in ascending order of values; infinite ones come last
    unit = np.repeat(np.arange(values.shape[0] * values.shape[1]), values.shape[2])[order[:finite]]
    ordered = flat[order[:finite]]
    # chunks of resamples
    means, step = [], max(1, _CHUNK // n)
    for start in range(0, len(by.seeds), step):
        rows = slice(start, start + step)
        taken = (by.seeds[rows, :, None] * by.plants[rows, None, :]).astype(float)
        ends = np.cumsum(np.take(taken.reshape(len(taken), -1), unit, axis=1), axis=1)
        counts = np.clip(ends, low, high, out=ends)
        sums = counts[:, -1] * ordered[-1] - low * ordered[0] - counts[:, :-1] @ np.diff(ordered)
        means.append(np.where(counts[:, -1] < high, np.inf, sums / (high - low)))
    return np.concatenate(means)


def difference(first: Array, second: Array) -> Array:
    """Subtract the second from the first; two that are both infinite do not differ."""
    same = np.asarray(first) == np.asarray(second)
    return np.where(same, 0.0, np.subtract(first, second, where=~same, out=np.zeros(np.shape(same))))


def interval(samples: Array, levels: int) -> Interval | None:
    """Compute the expanded percentile interval of a statistic in every resample, (R,); None if it is exact.

    `levels` is the number of seeds or plants that were resampled, the smaller one if both were.
    """
    if levels < 2:
        return None
    reach = np.sqrt(levels / (levels - 1)) * scipy.stats.t.ppf((1 - CONFIDENCE) / 2, levels - 1)
    tail = float(scipy.stats.norm.cdf(reach))
    low = np.quantile(samples, tail, method="lower")
    high = np.quantile(samples, 1 - tail, method="higher")
    return Interval(float(low), float(high))


def _draw(n: int, count: int, rng: np.random.Generator) -> IntArray:
    return rng.multinomial(n, np.full(n, 1 / n), size=count).astype(np.intp)


def _sum(values: Array, by: Resamples) -> Array:
    return cast(Array, np.einsum("rs,sp,rp->r", by.seeds, values, by.plants, optimize=True))


def _worst(values: Array) -> Array:
    return np.where(np.isnan(values), np.inf, values)
