"""What a sine explains, by frequency, and the exact frequency of a peak."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from ffgym.core.types import Array
from ffgym.diagnosis.patterns.candidate import fit

PADDING = 4
"""Transforms are so much longer than the data; a peak between two frequencies then keeps 0.95 of its energy."""

_FINE = 0.001
"""Tolerance of a refined frequency, in widths of its peak."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Spectrum:
    """Share of a residual's energy that a sine explains, by frequency."""

    frequency: Array
    """Cycles per motor turn, or [Hz], rising; shape (F,)."""
    share: Array
    """0 to 1, on the rows that it was fitted to, shape (F,)."""

    @property
    def best(self) -> float:
        """Frequency of the highest peak."""
        return float(self.frequency[np.argmax(self.share)])


def refined(frequency: float, within: float, columns: Callable[[float], Array], values: Array) -> float:
    """Frequency at most `within` from a peak whose centred columns (R, P) leave least of values (R,)."""

    def left(trial: float) -> float:
        fitted = columns(trial)
        rest = values - fitted @ fit(fitted, values)
        return float(rest @ rest)

    bounds = (frequency - within, frequency + within)
    best = minimize_scalar(left, bounds=bounds, method="bounded", options={"xatol": _FINE * within})
    return float(best.x)
