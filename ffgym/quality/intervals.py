"""Intervals of a clock: even ones, usual ones, gaps."""

import numpy as np

from ffgym.types import Array

EVEN = 0.01
"""Largest difference of sample periods that still counts as even, in sample periods."""

_GAP = 1.5
"""Periods from which on an interval is a gap: a missing row makes two. A clock that scatters has longer ones."""


def is_even(t: Array) -> bool:
    """Whether times [s] are of an even clock."""
    steps = np.diff(t)
    return bool(np.ptp(steps) <= EVEN * np.median(steps))


def longest_interval(t: Array) -> float:
    """Longest interval [s] that is no gap: five deviations of the clock above its median, `_GAP` periods at least."""
    intervals = np.diff(t)
    period = float(np.median(intervals))
    scatter = 1.4826 * float(np.median(np.abs(intervals - period)))
    return max(_GAP * period, period + 5 * scatter)
