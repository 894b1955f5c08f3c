"""Samples as they are compared: white noise above the band, and one low-pass for every signal."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.diagnosis.settings import settings
from ffgym.logs.preparation import LowPass

_FREQUENCIES = 500
"""Frequencies that a share of the band is summed over; chosen: a low-pass is smooth."""


def estimate_noise_above_band(values: Array, low_pass: LowPass, dt: float) -> Array:
    """Estimate the standard deviation of white noise of signals (T, C) above the low-pass, in their quiet blocks.

    Only blocks in which a signal moves count, if it does: a reading in steps that stands has no noise. The quality gate
    knows no band, and estimates noise by differences of rows.
    """
    limits = settings().sampling
    known = np.nan_to_num(values)
    slow = low_pass(known, dt)
    # share of the energy of white noise that is in what the low-pass takes from it
    frequency: Array = (np.arange(_FREQUENCIES, dtype=np.float64) + 0.5) / (2 * _FREQUENCIES * dt)
    share = max(limits.seen_band, float(np.mean((1 - low_pass.gain(frequency, dt)) ** 2)))
    ends = low_pass.end_rows(dt)
    inner = slice(ends, len(known) - ends) if len(known) > 4 * ends else slice(None)
    values_in_block = np.clip(
        share * limits.longest_block / dt,
        limits.fewest_values_per_block,
        limits.values_per_block,
    )
    width = round(values_in_block / share)
    local = np.mean(_in_blocks((known - slow)[inner], width) ** 2, axis=1)
    moves = np.ptp(_in_blocks(slow[inner], width), axis=1) > np.sqrt(local)
    moves = moves | (moves.sum(axis=0) < limits.fewest_blocks)
    energy = [_quiet(local[rows, c], share * width) for c, rows in enumerate(moves.T)]
    noise: Array = np.sqrt(np.array(energy) / share)
    return noise


def _in_blocks(values: Array, width: int) -> Array:
    """Rows (T, C) in blocks (B, width, C); what is left over at the end does not count, nor does more than there is."""
    width = min(width, len(values))
    n = len(values) // width
    return values[: n * width].reshape(n, width, -1)


def _quiet(energy: Array, known: float) -> float:
    """Energy of noise by that of blocks of so many independent values, of which some are loud.

    Chance makes some quiet, which is reckoned with.
    """
    limits = settings().noise
    if len(energy) < settings().sampling.fewest_blocks:
        return float(np.mean(energy))
    by_chance = float(scipy.stats.chi2.ppf(limits.quiet_share, known)) / known
    return float(np.quantile(energy, limits.quiet_share)) / by_chance


def without_trembling(angle: Array, width: Array) -> Array:
    """Angles (T, ..., N) that follow a signal only where it leaves a band of half `width` (N,) about them.

    A motor that stands is read with noise, whose speed would shake the bristles of its friction loose; a real motor
    stands. In motion the angle lags by the width, and its speed is that of the signal.
    """
    if not np.any(width > 0):
        return angle
    # bands that an angle is held in by all samples up to each; twice as many samples of them in every round
    low, high = angle - width, angle + width
    low[0], high[0] = angle[0], angle[0]
    reach = 1
    while reach < len(angle):
        before = low[:-reach], high[:-reach]
        low[reach:], high[reach:] = [np.minimum(np.maximum(x, low[reach:]), high[reach:]) for x in before]
        reach *= 2
    followed: Array = low  # the first sample leaves no choice
    return followed


_OF_SAMPLE_RATE = (0.25, 0.2)
"""Largest cut-offs as shares of the sample rate, of motion and comparison; slow logs are compared below those. A
narrower band leaves hardly a row of them that is far enough from all reversals: at 10 Hz and 1 Hz 13 % of rows."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Sampling:
    """Reduction of T samples, `dt` apart, to R rows: finite symmetric low-pass, then every n-th sample."""

    dt: float
    """Sample period of the recordings [s]."""
    n_samples: int
    """T, of the longest motion."""
    cutoff: float
    """Low-pass of what is compared [Hz]."""

    @classmethod
    def of(cls, dt: float, lengths: Sequence[int], cutoff: float | None = None) -> "Sampling":
        """Choose the band [Hz] for motions of `lengths` samples: the given, the usual, or a wider one if short."""
        limits = settings().sampling
        if cutoff is not None:
            return cls(dt=dt, n_samples=max(lengths), cutoff=cutoff)
        usual = min(limits.cutoff, _OF_SAMPLE_RATE[1] / dt)
        needed = limits.rows_of_short_log / (limits.rows_per_period * sum(lengths) * dt)
        widest = min(limits.motion_cutoff, limits.widest_cutoff / dt)
        return cls(dt=dt, n_samples=max(lengths), cutoff=max(usual, min(needed, widest)))

    @property
    def motion_filter(self) -> LowPass:
        """Low-pass of the measured motor angle."""
        limits = settings().sampling
        usual = min(
            limits.motion_cutoff,
            _OF_SAMPLE_RATE[0] / self.dt,
            limits.motion_over_cutoff * self.cutoff,
        )
        return LowPass(cutoff=max(usual, self.cutoff))

    @property
    def stride(self) -> int:
        """Samples from one row to the next."""
        return max(1, int(1 / (settings().sampling.rows_per_period * self.cutoff * self.dt)))

    @property
    def row_dt(self) -> float:
        """Time from one row to the next [s]."""
        return self.stride * self.dt

    def coarser(self, every: int) -> "Sampling":
        """The same rows from every n-th sample; `every` divides the stride."""
        return Sampling(dt=every * self.dt, n_samples=-(-self.n_samples // every), cutoff=self.cutoff)

    @property
    def span(self) -> float:
        """Time after which a record has more samples than T [s]."""
        return (self.n_samples - 0.5) * self.dt

    @property
    def half_length(self) -> int:
        """Samples on either side of a row that it depends on."""
        return round(settings().sampling.filter_half_length / (self.cutoff * self.dt))

    @cached_property
    def at(self) -> IntArray:
        """Samples at which the rows lie, shape (R,)."""
        return np.arange(0, self.n_samples, self.stride)

    @cached_property
    def operator(self) -> "scipy.sparse.csr_array":
        """The low-pass with its rows, shape (R, T); the end rows of a record are not `valid`."""
        half = self.half_length
        taps = scipy.signal.firwin(2 * half + 1, self.cutoff, fs=1 / self.dt)
        bands = scipy.sparse.diags_array(
            np.repeat(taps[:, None], self.n_samples, axis=1),
            offsets=range(-half, half + 1),
            shape=(self.n_samples, self.n_samples),
        )
        return scipy.sparse.csr_array(scipy.sparse.csr_array(bands)[self.at])

    def __call__(self, values: Array) -> Array:
        """Rows (R, ...) of samples (T, ...)."""
        flat = values.reshape(len(values), -1)
        rows: Array = self.operator @ flat
        return rows.reshape(len(rows), *values.shape[1:])

    def valid(self, known: BoolArray) -> BoolArray:
        """Rows that depend on samples `known` (T, M) alone, shape (R, M)."""
        unknown = np.cumsum(np.pad(~known, ((1, 0), (0, 0))), axis=0)
        low, high = self.at - self.half_length, self.at + self.half_length + 1
        inside = (low >= 0) & (high <= self.n_samples)
        count: IntArray = unknown[np.minimum(high, self.n_samples)] - unknown[np.maximum(low, 0)]
        rows: BoolArray = inside[:, None] & (count == 0)
        return rows
