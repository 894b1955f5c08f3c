"""Signals of a log: stretches and steps of a column, intervals of a clock, averages, noise; comparison of two."""

from dataclasses import dataclass

import numpy as np
import scipy

from ffgym.core.types import Array, BoolArray

TINY = float(np.finfo(np.float64).tiny)
"""Smallest number, so that shares of what is zero are finite."""

EVEN = 0.01
"""Largest difference of sample periods that still counts as even, in sample periods."""

_GAP = 1.5
"""Periods from which on an interval is a gap: a missing row makes two. A clock that scatters has longer ones."""

_ROUNDING = 1e-6
"""Share of the range of a column below which a difference is rounding: of a speed from differences of large angles it
is 1e-9, of the finest encoder in use a step is 1e-5."""

_ORDER = 4
"""Order of the differences in which noise is seen: motion of frequency f keeps (2 sin(pi f dt))^4 of its amplitude, at
5 Hz and 250 Hz 2e-4."""

_NORMAL = 0.6745
"""Median size of a normal variable in its standard deviations."""


def stretches(inside: BoolArray, shortest: int = 1) -> list[slice]:
    """Stretches of rows that are `inside` (T,), at least `shortest` long, in order."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], inside.astype(np.int8), [0]])))
    pairs = edges.reshape(-1, 2)
    return [slice(int(start), int(stop)) for start, stop in pairs if stop - start >= shortest]


def constant_stretches(x: Array, shortest: int) -> list[slice]:
    """Stretches of one value in `x` (T,), at least `shortest` rows long."""
    return [slice(rows.start, rows.stop + 1) for rows in stretches(np.diff(x) == 0, shortest - 1)]


def smallest_step(x: Array, least: int = 1) -> float:
    """Smallest difference between neighbours in `x` (T,) that is more than rounding; 0 if fewer than `least` are."""
    steps = np.abs(np.diff(x))
    steps = steps[steps > _ROUNDING * np.ptp(x)]
    return float(steps.min()) if steps.size >= least else 0.0


def grid_step(x: Array) -> float:
    """Step of the grid on which all values of `x` (T,) lie; 0 if they lie on none.

    Ten different values must fit to a hundredth of a step: three always do.
    """
    values = np.unique(x)
    step = smallest_step(values)
    if step == 0.0 or len(values) < 10:
        return 0.0
    offsets = (values - values[0]) / step
    off = np.abs(offsets - np.round(offsets))
    return step if np.all(off < 0.01 + _ROUNDING * offsets.max()) else 0.0


def is_even(t: Array) -> bool:
    """Tell whether times [s] are of an even clock."""
    steps = np.diff(t)
    return bool(np.ptp(steps) <= EVEN * np.median(steps))


def has_two_rates(t: Array) -> bool:
    """Tell whether times [s] are of one even clock up to some row, and of another one from there on."""
    steps = np.diff(t)
    slow, fast = (float(np.quantile(steps, share)) for share in (0.75, 0.25))
    if slow <= (1 + EVEN) * fast:
        return False
    is_slow = steps > np.sqrt(slow * fast)
    parts = (steps[is_slow], steps[~is_slow])
    are_even = all(np.ptp(part) <= EVEN * np.median(part) for part in parts)
    return are_even and np.count_nonzero(np.diff(is_slow)) == 1


def longest_interval(t: Array) -> float:
    """Longest interval [s] that is no gap: five deviations of the clock above its median, `_GAP` periods at least."""
    intervals = np.diff(t)
    period = float(np.median(intervals))
    scatter = 1.4826 * float(np.median(np.abs(intervals - period)))
    return max(_GAP * period, period + 5 * scatter)


def average(values: Array, rows: int) -> Array:
    """Moving average along the first axis, without delay."""
    return scipy.ndimage.uniform_filter1d(values, rows | 1, axis=0, mode="nearest")


def estimate_noise_by_differences(values: Array) -> Array:
    """Estimate the standard deviation of white noise of signals (T, C), rows evenly spaced, by high differences.

    Bursts, jumps and stops do not move their median. For slow sampling it is an upper bound.
    """
    if len(values) <= 4 * _ORDER:
        return np.zeros(values.shape[1])
    gain = np.sqrt(sum(scipy.special.comb(_ORDER, k) ** 2 for k in range(_ORDER + 1)))
    sizes = np.abs(np.diff(values, _ORDER, axis=0))
    return np.asarray(np.median(sizes, axis=0) / (_NORMAL * gain))


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """Signal a in terms of signal b, by their increments."""

    slope: float
    """Size of a over size of b, negative if they go opposite ways; nan if b does not change."""
    correlation: float
    """In [-1, 1], at `lag`; 0 if one does not change."""
    lag: float
    """Number of rows by which a is later than b."""


def compare(a: Array, b: Array, lags: int = 0) -> Comparison:
    """Compare increments `a` and `b` (T,), shifted by up to `lags` rows against each other."""
    size_a, size_b = float(np.sqrt(np.sum(a**2))), float(np.sqrt(np.sum(b**2)))
    if size_a == 0.0 or size_b == 0.0:
        return Comparison(slope=np.nan if size_b == 0.0 else 0.0, correlation=0.0, lag=0.0)
    if lags == 0:
        correlation, lag = float(np.sum(a * b) / (size_a * size_b)), 0.0
    else:  # the correlation of largest size, and where it is, between rows by a parabola
        near = np.abs(scipy.signal.correlation_lags(len(a), len(b))) <= lags
        curve = scipy.signal.correlate(a, b, method="fft")[near] / (size_a * size_b)
        peak = int(np.argmax(np.abs(curve)))
        correlation, lag = float(curve[peak]), float(peak - (len(curve) - 1) // 2)
        if 0 < peak < len(curve) - 1:
            before, top, after = curve[peak - 1 : peak + 2]
            bend = before - 2 * top + after
            lag += 0.5 * float((before - after) / bend) if bend else 0.0
    return Comparison(slope=float(np.copysign(size_a / size_b, correlation)), correlation=correlation, lag=lag)


def correlations(a: Array, b: Array) -> tuple[Array, Array]:
    """Slopes and correlations, (N, N) each, of columns i of `a` in terms of columns j of `b`, both (T, N)."""
    size_a, size_b = np.sqrt(np.sum(a**2, axis=0)), np.sqrt(np.sum(b**2, axis=0))
    with np.errstate(divide="ignore", invalid="ignore"):
        correlation = np.nan_to_num((a.T @ b) / np.outer(size_a, size_b))
        slope = np.copysign(size_a[:, None] / size_b[None, :], correlation)
    return slope, correlation
