"""White noise of measured signals, seen above the band in which machines move."""

import numpy as np
from scipy.stats import chi2

from ffgym.core.types import Array
from ffgym.diagnosis.identification import LowPass

_LEAST = 0.05
"""Share of the band that is taken to be seen at least, however high the low-pass."""

_FREQUENCIES = 500
"""Frequencies that a share of the band is summed over; chosen: a low-pass is smooth."""

_KNOWN = 20
"""Independent values in a block, from which its noise is known to a sixth; fewer in one that would last too long."""

_FEWEST = 6
"""Independent values in a block at least."""

_LONGEST = 0.1
"""Time [s] that a block should last at most; chosen: most of those between two reversals show none of them."""

_QUIET = 0.25
"""Share of the blocks that show noise alone; what a machine does above its band, as resolvers that err in fast motion,
is no noise."""

_FEW = 8
"""Blocks below which quiet ones are not told from others."""


def white_noise(values: Array, low_pass: LowPass, dt: float) -> Array:
    """Standard deviation of the white noise of signals (T, C): what is above the low-pass where it is quiet.

    Only blocks in which a signal moves count, if it does: a reading in steps that stands has no noise.
    """
    known = np.nan_to_num(values)
    slow = low_pass(known, dt)
    share = max(_LEAST, share_of_noise(low_pass, dt))
    ends = low_pass.end_rows(dt)
    inner = slice(ends, len(known) - ends) if len(known) > 4 * ends else slice(None)
    values_in_block = np.clip(share * _LONGEST / dt, _FEWEST, _KNOWN)
    width = round(values_in_block / share)
    local = np.mean(_in_blocks((known - slow)[inner], width) ** 2, axis=1)
    moves = np.ptp(_in_blocks(slow[inner], width), axis=1) > np.sqrt(local)
    moves = moves | (moves.sum(axis=0) < _FEW)
    energy = [_quiet(local[rows, c], share * width) for c, rows in enumerate(moves.T)]
    noise: Array = np.sqrt(np.array(energy) / share)
    return noise


def share_of_noise(low_pass: LowPass, dt: float) -> float:
    """Share of the energy of white noise, samples `dt` [s] apart, that is in what a low-pass takes from it."""
    frequency: Array = (np.arange(_FREQUENCIES, dtype=np.float64) + 0.5) / (2 * _FREQUENCIES * dt)
    return float(np.mean((1 - taken(low_pass, frequency, dt)) ** 2))


def taken(low_pass: LowPass, frequency: Array, dt: float) -> Array:
    """Share of signals of some frequencies [Hz], samples `dt` [s] apart, that passes both runs of a low-pass."""
    ratio = np.tan(np.pi * dt * frequency) / np.tan(np.pi * dt * low_pass.cutoff)
    passed: Array = 1 / (1 + ratio ** (2 * low_pass.order))
    return passed


def _in_blocks(values: Array, width: int) -> Array:
    """Rows (T, C) in blocks (B, width, C); what is left over at the end does not count, nor does more than there is."""
    width = min(width, len(values))
    n = len(values) // width
    return values[: n * width].reshape(n, width, -1)


def _quiet(energy: Array, known: float) -> float:
    """Energy of noise by that of blocks of so many independent values, of which some are loud.

    Chance makes some quiet, which is reckoned with.
    """
    if len(energy) < _FEW:
        return float(np.mean(energy))
    by_chance = float(chi2.ppf(_QUIET, known)) / known
    return float(np.quantile(energy, _QUIET)) / by_chance


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
