"""White noise of measured signals, seen above the band in which machines move."""

import numpy as np
from scipy.stats import chi2

from ffgym.identification import LowPass
from ffgym.types import Array

_LEAST = 0.05
"""Share of the band that is taken to be seen at least, however high the low-pass."""

_KNOWN = 20
"""Independent values in a block, from which its noise is known to a sixth."""

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
    share = max(_LEAST, 1.0 - 2.0 * low_pass.cutoff * dt)
    ends = low_pass.end_rows(dt)
    inner = slice(ends, len(known) - ends) if len(known) > 4 * ends else slice(None)
    width = round(_KNOWN / share)
    local = np.mean(_in_blocks((known - slow)[inner], width) ** 2, axis=1)
    moves = np.ptp(_in_blocks(slow[inner], width), axis=1) > np.sqrt(local)
    moves = moves | (moves.sum(axis=0) < _FEW)
    energy = [_quiet(local[rows, c]) for c, rows in enumerate(moves.T)]
    noise: Array = np.sqrt(np.array(energy) / share)
    return noise


def _in_blocks(values: Array, width: int) -> Array:
    """Rows (T, C) in blocks (B, width, C); what is left over at the end does not count, nor does more than there is."""
    width = min(width, len(values))
    n = len(values) // width
    return values[: n * width].reshape(n, width, -1)


def _quiet(energy: Array) -> float:
    """Energy of noise by that of blocks, of which some are loud; chance makes some quiet, which is reckoned with."""
    if len(energy) < _FEW:
        return float(np.mean(energy))
    by_chance = float(chi2.ppf(_QUIET, _KNOWN)) / _KNOWN
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
