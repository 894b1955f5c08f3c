"""Long signals drawn with few points, without losing a peak."""

import numpy as np

from ffgym.core.types import Array, IntArray

POINTS = 2000
"""Points of a line that are drawn: twice the pixels of a figure's width."""


def peaks_kept(values: Array, points: int = POINTS) -> IntArray:
    """Rows of `values` (T,) to draw, ascending: the smallest and the largest of each of points / 2 stretches.

    All rows if there are no more than `points`; NaN stands for a gap and is never chosen where there is a number.
    """
    if len(values) <= points:
        return np.arange(len(values))
    stretches = np.array_split(np.arange(len(values)), points // 2)
    chosen = [_extremes(values[rows]) + rows[0] for rows in stretches]
    return np.unique(np.concatenate([[0], *chosen, [len(values) - 1]]))


def _extremes(values: Array) -> IntArray:
    if np.isnan(values).all():
        return np.array([0])
    return np.array([np.nanargmin(values), np.nanargmax(values)])
