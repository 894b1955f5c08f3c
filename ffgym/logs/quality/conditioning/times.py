"""When rows were sampled: at their time stamps, or evenly, where stamps tell less than the motion does."""

from dataclasses import dataclass

import numpy as np

from ffgym.core.types import Array, BoolArray
from ffgym.logs.quality.log import Log
from ffgym.logs.quality.rows import long_intervals
from ffgym.logs.quality.signals import longest_interval

_NO_WORSE = 1.02
"""Roughness of the motion, over that at the time stamps, up to which even times are taken: they leave values as they
are. Noise alone makes both alike."""

_BATCHES = 1.5
"""Mean interval over the median from which on rows come in batches, and the mean is the period."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Times:
    """Times of S rows."""

    s: Array
    """[s], increasing, shape (S,)."""
    period: float
    """Of the even clock that they are to be brought to [s]."""
    kept: bool
    """Whether they are the time stamps."""
    stepped: bool = False
    """Whether steps of the clock were taken out."""


def times_of(log: Log) -> Times:
    """When the rows of a log were sampled, as its positions say: of possible times, those at which they are smooth.

    A controller that stamps its rows right is believed, however unevenly it is read. Stamps of a clock that is coarse,
    or of the arrival of a message, scatter about even times, and make the motion rough that is smooth at those. Steps
    of the clock over which the joints move on as in one interval are taken out before.
    """
    t = _without_steps(log)
    stepped = t is not log.t
    stamps = Times(s=t, period=_period(t), kept=True, stepped=stepped)
    even = _evenly(t, stepped=stepped)
    if not log.excited.any():
        return even
    q = log.q[:, log.excited]
    rough = float(np.exp(np.mean(np.log(_roughness(even.s, q) / _roughness(t, q)))))
    return even if rough <= _NO_WORSE else stamps


def _without_steps(log: Log) -> Array:
    """Time stamps without the steps of their clock."""
    rows, moved = long_intervals(log)
    if moved.all():
        return log.t
    excess = np.zeros(len(log.t))
    excess[rows[~moved] + 1] = np.diff(log.t)[rows[~moved]] - log.dt
    return np.asarray(log.t - np.cumsum(excess))


def _period(t: Array) -> float:
    """Period of an even clock for these times [s], without the digits that rounding of large times leaves."""
    steps = np.diff(t)
    period, mean = float(np.median(steps)), float(t[-1] - t[0]) / len(steps)
    return float(f"{mean if mean > _BATCHES * period else period:.9g}")


def _counts(t: Array) -> Array:
    """Number of each row, those that are missing counted."""
    steps = np.diff(t)
    usual = steps[steps <= longest_interval(t)]
    period = float(np.mean(usual))
    missing = np.where(steps > longest_interval(t), np.maximum(np.round(steps / period) - 1, 0), 0)
    return np.concatenate([[0.0], np.cumsum(1 + missing)])


def _evenly(t: Array, *, stepped: bool) -> Times:
    """Even times for rows, and those that are missing between them: the straight line through their stamps."""
    counts = _counts(t)
    period, first = (float(x) for x in np.polyfit(counts, t - t[0], 1))
    period = float(f"{period:.9g}")
    return Times(s=t[0] + first + period * counts, period=period, kept=False, stepped=stepped)


def _roughness(s: Array, q: Array) -> Array:
    """Size of what positions (T, N) are off the cubic through two neighbours on either side, (N,)."""
    rows = [slice(k, len(s) - 4 + k) for k in range(5)]
    middle, around = s[rows[2]], [0, 1, 3, 4]
    guess = np.zeros((len(s) - 4, q.shape[1]))
    for i in around:
        weight = np.ones(len(s) - 4)
        for k in around:
            if k != i:
                weight *= (middle - s[rows[k]]) / (s[rows[i]] - s[rows[k]])
        guess += weight[:, None] * q[rows[i]]
    size: Array = np.sqrt(np.mean((q[rows[2]] - guess) ** 2, axis=0))
    return np.maximum(size, np.finfo(np.float64).tiny)


def in_gaps(s: Array, t: Array, period: float, least: float) -> BoolArray:
    """Times `t` (T,) strictly within intervals of `s` (S,) that are longer than a period by more than `least` [s]."""
    after = np.clip(np.searchsorted(s, t - 1e-6 * period), 1, len(s) - 1)
    width = s[after] - s[after - 1]
    near = np.minimum(np.abs(t - s[after]), np.abs(t - s[after - 1])) < 1e-3 * period
    return np.asarray((width - period > max(least, 0.5 * period)) & ~near)
