"""Intervals of a clock: even ones, usual ones, gaps."""

import numpy as np

from ffgym.core.types import Array

EVEN = 0.01
"""Largest difference of sample periods that still counts as even, in sample periods."""

_GAP = 1.5
"""Periods from which on an interval is a gap: a missing row makes two. A clock that scatters has longer ones."""


def is_even(t: Array) -> bool:
    """Whether times [s] are of an even clock."""
    steps = np.diff(t)
    return bool(np.ptp(steps) <= EVEN * np.median(steps))


def has_two_rates(t: Array) -> bool:
    """Whether times [s] are of one even clock up to some row, and of another one from there on."""
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
