"""White noise of measured signals, seen where no planned motion is: in differences of high order."""

import numpy as np
from scipy.special import comb

from ffgym.core.types import Array

_ORDER = 4
"""Of the differences: motion of frequency f keeps (2 sin(pi f dt))^4 of its amplitude, at 5 Hz and 250 Hz 2e-4."""

_NORMAL = 0.6745
"""Median size of a normal variable in its standard deviations."""


def white_noise(values: Array) -> Array:
    """Standard deviation of the white noise of signals (T, C), rows evenly spaced; an upper bound for slow sampling.

    The median of high differences, which bursts, jumps and stops do not move.
    """
    if len(values) <= 4 * _ORDER:
        return np.zeros(values.shape[1])
    gain = np.sqrt(sum(comb(_ORDER, k) ** 2 for k in range(_ORDER + 1)))
    sizes = np.abs(np.diff(values, _ORDER, axis=0))
    return np.asarray(np.median(sizes, axis=0) / (_NORMAL * gain))


def acceleration_noise(noise: Array, dt: float, cutoff: float) -> Array:
    """Noise of the second derivative of white `noise` (C,), sampled every `dt` [s], behind a low-pass at `cutoff` [Hz].

    Of the density 2 dt noise^2 up to the cut-off, times (2 pi f)^4.
    """
    return np.asarray(noise * (2 * np.pi * cutoff) ** 2 * np.sqrt(2 * dt * cutoff / 5))
