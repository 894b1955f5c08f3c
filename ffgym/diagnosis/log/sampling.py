"""Every signal, measured or predicted, through the same low-pass without delay, at few enough rows."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.signal import firwin
from scipy.sparse import csr_array, diags_array

from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.diagnosis.identification import LowPass

MOTION_CUTOFF = 100.0
"""Low-pass of the motor angle before it is differentiated [Hz]; that of `ffgym.diagnosis.identification`: reversals
take 7 ms."""

CUTOFF = 40.0
"""Low-pass of what is compared [Hz]: above the resonances of industrial robots, 5 to 30 Hz, and thesis 6.1.2."""

_OF_SAMPLE_RATE = (0.25, 0.2)
"""Largest cut-offs as shares of the sample rate, of motion and comparison; slow logs are compared below those. A
narrower band leaves hardly a row of them that is far enough from all reversals: at 10 Hz and 1 Hz 13 % of rows."""

_MOTION_OVER = 2.5
"""Cut-off of the motion over that of what is compared, at most; what is above shows in neither."""

_ROWS = 3000
"""Rows that all motions together shall have; chosen: 40 s at 25 Hz. A shorter log has them from a wider band, where
what repeats with the motor's turns is seen best."""

_WIDEST = 0.38
"""Largest cut-off of a short log, as a share of the sample rate: below half of it, where filters still have room."""

_LENGTH = 2.0
"""Half the length of the low-pass of what is compared, in periods of its cut-off; chosen: 50 ms at 40 Hz."""

_ROWS_PER_PERIOD = 3
"""Rows kept per period of the cut-off; chosen: hardly more than what is needed to know the signal."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Sampling:
    """How signals of T samples, `dt` apart, become R rows: finite symmetric low-pass, then every n-th sample."""

    dt: float
    """Sample period of the recordings [s]."""
    n_samples: int
    """T, of the longest motion."""
    cutoff: float
    """Low-pass of what is compared [Hz]."""

    @classmethod
    def of(cls, dt: float, lengths: Sequence[int], cutoff: float | None = None) -> "Sampling":
        """For motions of so many samples each: a given band [Hz], else the usual one or, if they are short, a wider."""
        if cutoff is not None:
            return cls(dt=dt, n_samples=max(lengths), cutoff=cutoff)
        usual = min(CUTOFF, _OF_SAMPLE_RATE[1] / dt)
        needed = _ROWS / (_ROWS_PER_PERIOD * sum(lengths) * dt)
        widest = min(MOTION_CUTOFF, _WIDEST / dt)
        return cls(dt=dt, n_samples=max(lengths), cutoff=max(usual, min(needed, widest)))

    @property
    def motion_filter(self) -> LowPass:
        """Low-pass of the measured motor angle."""
        usual = min(MOTION_CUTOFF, _OF_SAMPLE_RATE[0] / self.dt, _MOTION_OVER * self.cutoff)
        return LowPass(cutoff=max(usual, self.cutoff))

    @property
    def stride(self) -> int:
        """Samples from one row to the next."""
        return max(1, int(1 / (_ROWS_PER_PERIOD * self.cutoff * self.dt)))

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
        return round(_LENGTH / (self.cutoff * self.dt))

    @cached_property
    def at(self) -> IntArray:
        """Samples at which the rows lie, shape (R,)."""
        return np.arange(0, self.n_samples, self.stride)

    @cached_property
    def operator(self) -> csr_array:
        """The low-pass with its rows, shape (R, T); the end rows of a record are not `valid`."""
        half = self.half_length
        taps = firwin(2 * half + 1, self.cutoff, fs=1 / self.dt)
        bands = diags_array(
            np.repeat(taps[:, None], self.n_samples, axis=1),
            offsets=range(-half, half + 1),
            shape=(self.n_samples, self.n_samples),
        )
        return csr_array(csr_array(bands)[self.at])

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
