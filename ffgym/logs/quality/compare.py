"""Two signals that should be one: how large one is in terms of the other, how alike, and how late."""

from dataclasses import dataclass
from typing import final

import numpy as np
from scipy.signal import correlate, correlation_lags

from ffgym.core.types import Array


@final
@dataclass(frozen=True, kw_only=True)
class Comparison:
    """Signal a in terms of signal b, by their increments."""

    slope: float
    """Size of a over size of b, negative if they go opposite ways; nan if b does not change."""
    correlation: float
    """In [-1, 1], at `lag`; 0 if one does not change."""
    lag: float
    """By how many rows a is later than b."""


def compare(a: Array, b: Array, lags: int = 0) -> Comparison:
    """Compare increments `a` and `b` (T,), shifted by up to `lags` rows against each other."""
    size_a, size_b = float(np.sqrt(np.sum(a**2))), float(np.sqrt(np.sum(b**2)))
    if size_a == 0.0 or size_b == 0.0:
        return Comparison(slope=np.nan if size_b == 0.0 else 0.0, correlation=0.0, lag=0.0)
    if lags == 0:
        correlation, lag = float(np.sum(a * b) / (size_a * size_b)), 0.0
    else:
        correlation, lag = _peak(a, b, lags, size_a * size_b)
    return Comparison(slope=float(np.copysign(size_a / size_b, correlation)), correlation=correlation, lag=lag)


def _peak(a: Array, b: Array, lags: int, size: float) -> tuple[float, float]:
    """Correlation of largest size within `lags` rows, and where it is, between rows by a parabola."""
    near = np.abs(correlation_lags(len(a), len(b))) <= lags
    curve = correlate(a, b, method="fft")[near] / size
    peak = int(np.argmax(np.abs(curve)))
    lag = float(peak - (len(curve) - 1) // 2)
    if 0 < peak < len(curve) - 1:
        before, top, after = curve[peak - 1 : peak + 2]
        bend = before - 2 * top + after
        lag += 0.5 * float((before - after) / bend) if bend else 0.0
    return float(curve[peak]), lag


def correlations(a: Array, b: Array) -> tuple[Array, Array]:
    """Slopes and correlations, (N, N) each, of columns i of `a` in terms of columns j of `b`, both (T, N)."""
    size_a, size_b = np.sqrt(np.sum(a**2, axis=0)), np.sqrt(np.sum(b**2, axis=0))
    with np.errstate(divide="ignore", invalid="ignore"):
        correlation = np.nan_to_num((a.T @ b) / np.outer(size_a, size_b))
        slope = np.copysign(size_a[:, None] / size_b[None, :], correlation)
    return slope, correlation
