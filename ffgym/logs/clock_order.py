"""Rows of a file whose clock repeats a time or goes back: left out, and told."""

from bisect import bisect_left

import numpy as np

from ffgym.core.types import Array, BoolArray

_BACK = 0.01
"""Share of the rows that may go back in time; a clock that does so more often, or starts again, is none."""


def increasing(t: Array) -> BoolArray:
    """Rows to keep so that times (T,) increase: most of them, the first of equal ones; all where too many go back."""
    everything = np.ones(len(t), dtype=np.bool_)
    if not np.isfinite(t).all() or bool(np.all(np.diff(t) > 0)):
        return everything
    kept = _longest_increasing(t)
    return everything if _back(t, kept) > max(1.0, _BACK * len(t)) else kept


def order_note(t: Array, kept: BoolArray) -> str:
    """What was left out, in a sentence."""
    back = _back(t, kept)
    twice = int((~kept).sum()) - back
    texts = [
        f"{n} {what}" for n, what in ((twice, "with the time of another row"), (back, "that go back in time")) if n
    ]
    return f"Rows of the file were dropped: {' and '.join(texts)}, the first in row {int(np.argmin(kept))}."


def _back(t: Array, kept: BoolArray) -> int:
    """Rows that are not `kept` (T,) and do not have the time of the kept row before them either."""
    last = np.maximum.accumulate(np.where(kept, np.arange(len(t)), 0))
    return int((~kept & (t != t[last])).sum())


def _longest_increasing(t: Array) -> BoolArray:
    """Rows of the longest increasing subsequence, by patience sorting; of equal times the first."""
    ends: list[float] = []
    rows: list[int] = []
    before = np.full(len(t), -1)
    for row, time in enumerate(t.tolist()):
        place = bisect_left(ends, time)
        if place < len(ends) and ends[place] == time:
            continue  # the first of equal times stays
        before[row] = rows[place - 1] if place else -1
        ends[place : place + 1] = [time]
        rows[place : place + 1] = [row]
    kept = np.zeros(len(t), dtype=np.bool_)
    row = rows[-1]
    while row >= 0:
        kept[row] = True
        row = int(before[row])
    return kept
