"""Periodogram over time, in which each motion has a phase and an amplitude of its own."""

from itertools import pairwise

import numpy as np
from scipy.fft import next_fast_len, rfft

from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.patterns.rows import Rows
from ffgym.diagnosis.patterns.spectrum import PADDING, Spectrum


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
