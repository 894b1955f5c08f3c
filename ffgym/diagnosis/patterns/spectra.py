"""What a sine explains, by frequency: over the uneven angle of a motor, and over time."""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.fft import next_fast_len, rfft
from scipy.optimize import minimize_scalar

from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.diagnosis.patterns.forms import PRIOR_ROWS, fit
from ffgym.diagnosis.patterns.rows import Rows

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


CELLS = 16
"""Cells of the angle in one cycle; a value at the edge of its cell then counts for 0.98 of itself."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Turning:
    """What a motor did in the rows (R,) that a periodogram is made of."""

    angle: Array
    """[rad]."""
    speed: Array
    """[rad/s]."""
    gain: Array
    """What the amplitude of the sine goes with."""
    motion: IntArray
    """Motion of each row; each has a mean of its own."""
    highest: float
    """Frequency in time up to which rows show a vibration [Hz]."""


def angle_spectrum(turning: Turning, values: Array, *, low: float, high: float) -> list[Spectrum]:
    """Periodograms of values (R, C) over the motor angle from `low` to `high` cycles per turn, one for each column.

    Where a motor is so fast that rows do not show a vibration, they do not count for it. So each octave of frequencies
    has rows of its own.

    Reference:
        Zechmeister, Kuerster (2009), Astronomy & Astrophysics 496, 577-584: periodogram of a sine beside a mean.
    """
    edges = np.geomspace(low, high, max(1, round(np.log2(high / low))) + 1)
    found = [_octave(turning, values, float(start), float(stop)) for start, stop in pairwise(edges)]
    frequency = np.concatenate([frequency for frequency, _ in found])
    explained = np.concatenate([explained for _, explained in found], axis=1)
    energy = np.sum(values**2, axis=0)[:, None]
    share = np.divide(explained, energy, out=np.zeros_like(explained), where=energy > 0)
    return [Spectrum(frequency=frequency, share=one) for one in np.clip(share, 0.0, 1.0)]


def passed(speed: Array, frequency: float, highest: float) -> BoolArray:
    """Rows in which `frequency` cycles per turn are slow enough to be seen."""
    slow: BoolArray = frequency * np.abs(speed) / (2 * np.pi) < highest
    return slow


def _octave(turning: Turning, values: Array, low: float, high: float) -> tuple[Array, Array]:
    """Frequencies (F,) from `low` to `high`, and the energy (C, F) that a sine of each explains."""
    gain = np.where(passed(turning.speed, high, turning.highest), turning.gain, 0.0)
    cell = 1.0 / (CELLS * high)
    number = np.rint((turning.angle - turning.angle.min()) / (2 * np.pi * cell)).astype(np.intp)
    size = next_fast_len(max(PADDING * (int(number.max()) + 1), round(4 / (cell * low))), real=True)
    frequency = np.arange(size // 2 + 1) / (size * cell)
    chosen = np.flatnonzero((frequency >= low) & (frequency < high))

    def sums(weights: Array, times: int = 1) -> tuple[Array, Array]:
        """Sums of weights (R,) times cosine and sine of so many times the phase, (F,) each."""
        transform = rfft(np.bincount(number, weights=weights), size)[times * chosen]
        return transform.real, -transform.imag

    double, mixed = sums(gain**2, times=2)
    cosines = 0.5 * (gain @ gain + double) + PRIOR_ROWS
    sines = 0.5 * (gain @ gain - double) + PRIOR_ROWS
    both = 0.5 * mixed
    for motion, count in enumerate(np.bincount(turning.motion)):
        if count:
            c, s = sums(np.where(turning.motion == motion, gain, 0.0))
            cosines, sines, both = cosines - c**2 / count, sines - s**2 / count, both - c * s / count
    explained = []
    for column in values.T:
        c, s = sums(gain * column)
        explained.append((sines * c**2 - 2 * both * c * s + cosines * s**2) / (cosines * sines - both**2))
    return frequency[chosen], np.stack(explained)


def time_spectrum(rows: Rows, values: Array, train: BoolArray, *, low: float, high: float) -> Spectrum:
    """Periodogram of values (R,) in the rows of `train`, from `low` to `high` [Hz]."""
    edges = [*rows.motion_starts, len(values)]
    longest = max(np.ptp(rows.did.t[a:b]) for a, b in pairwise(edges))
    size = next_fast_len(max(4, round(PADDING * longest / rows.dt)), real=True)
    total = np.zeros(size // 2 + 1)
    for a, b in pairwise(edges):
        used = train[a:b]
        if used.any():
            at = np.rint((rows.did.t[a:b][used] - rows.did.t[a]) / rows.dt).astype(np.intp)
            total += 2 * np.abs(rfft(np.bincount(at, weights=values[a:b][used]), size)) ** 2 / used.sum()
    frequency = np.arange(len(total)) / (size * rows.dt)
    chosen = (frequency >= low) & (frequency <= high)
    energy = float(values[train] @ values[train])
    share = total[chosen] / energy if energy > 0 else np.zeros(int(chosen.sum()))
    return Spectrum(frequency=frequency[chosen], share=np.minimum(share, 1.0))
