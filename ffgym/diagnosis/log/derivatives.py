"""Speeds and accelerations of sampled angles, right up to half the sample rate."""

from collections.abc import Sequence

import numpy as np
from scipy.fft import dct, dst

from ffgym.core.types import Array


def derivatives(angle: Array, dt: float) -> tuple[Array, Array]:
    """First and second derivative of samples (T, ...) along time, T > 2.

    Those of the sine series through the samples, less their chord: a motion that rests at both ends goes on smoothly
    beyond them. Differences of neighbours lose 1 - (sin x / x)^2 of an acceleration, x = 2 pi f dt: a third of it at a
    tenth of the sample rate twice over, which would be seen as a wrong inertia. What is above the band of the motion is
    not damped here; low-pass before.
    """
    n = len(angle) - 1
    chord = (angle[-1] - angle[0]) / n
    k = np.arange(n + 1).reshape(-1, *(1,) * (angle.ndim - 1))
    inner = (angle - angle[0] - chord * k)[1:-1]
    frequency = np.pi * k[1:-1] / (n * dt)
    series = dst(inner, type=1, axis=0) / n
    rate = np.zeros_like(angle)
    rate[1:-1] = frequency * series
    change = np.zeros_like(angle)
    change[1:-1] = dst(-(frequency**2) * series, type=1, axis=0) / 2
    first: Array = dct(rate, type=1, axis=0) / 2 + chord / dt
    return first, change


def derivatives_of_motions(angle: Array, lengths: Sequence[int], dt: float) -> tuple[Array, Array]:
    """Those of motions side by side (T, M, ...), each of its own length; 0 in what is padded."""
    first, second = np.zeros_like(angle), np.zeros_like(angle)
    for i, n in enumerate(lengths):
        first[:n, i], second[:n, i] = derivatives(angle[:n, i], dt)
    return first, second
