"""White noise of measured signals, seen above the band in which machines move."""

import numpy as np

from ffgym.identification import LowPass
from ffgym.types import Array

_LEAST = 0.05
"""Share of the band that is taken to be seen at least, however high the low-pass."""

_OF_MEDIAN = 1.4826
"""Standard deviation over median absolute deviation, of normal noise."""


def white_noise(values: Array, low_pass: LowPass, dt: float) -> Array:
    """Standard deviation of the white noise of signals (T, C), from what is above the low-pass; robust to peaks."""
    known = np.nan_to_num(values)
    rest = known - low_pass(known, dt)
    share = max(_LEAST, 1.0 - 2.0 * low_pass.cutoff * dt)
    ends = low_pass.end_rows(dt)
    middle = rest[ends : len(rest) - ends] if len(rest) > 4 * ends else rest
    deviation = _OF_MEDIAN * np.median(np.abs(middle - np.median(middle, axis=0)), axis=0)
    rms = np.sqrt(np.mean(middle**2, axis=0))
    noise: Array = np.maximum(deviation, np.minimum(rms, 2 * deviation)) / np.sqrt(share)
    return noise


def without_trembling(angle: Array, width: Array) -> Array:
    """Angles (T, ..., N) that follow a signal only where it leaves a band of half `width` (N,) about them.

    A motor that stands is read with noise, whose speed would shake the bristles of its friction loose; a real motor
    stands. In motion the angle lags by the width, and its speed is that of the signal.
    """
    if not np.any(width > 0):
        return angle
    followed = np.empty_like(angle)
    at = angle[0]
    low, high = angle - width, angle + width
    for k in range(len(angle)):
        at = np.minimum(np.maximum(at, low[k]), high[k])
        followed[k] = at
    return followed
