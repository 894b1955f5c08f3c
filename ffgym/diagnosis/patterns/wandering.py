"""What goes with nothing but time: a residual that is like itself a moment later."""

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.patterns.dependence import Dependence
from ffgym.diagnosis.patterns.rows import Rows
from ffgym.diagnosis.patterns.split_half import symmetric_test

APART = 2
"""Blocks that are compared are so far apart; next to each other they share what the low-pass spreads."""


def wandering(rows: Rows, values: Array, level: float) -> Dependence | None:
    """Whether values (R,) wander: blocks of a motion, a fifth of a second apart, agree in sign more than by chance."""
    means, motion = rows.by_block(values[:, None])[:, 0], rows.motion[rows.block_starts]
    pairs = np.flatnonzero(motion[APART:] == motion[:-APART])
    before, after = means[pairs], means[pairs + APART]
    size = np.abs(before * after)
    agreement = before * after / (size + np.median(size) + np.finfo(np.float64).tiny)
    if symmetric_test(agreement[:, None])[0] > level:
        return None
    alike = float(np.sum(before * after) / np.sqrt(np.sum(before**2) * np.sum(after**2)))
    return Dependence(variable="time", joint=None, correlation=max(alike, 0.0))
