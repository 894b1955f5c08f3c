"""Cells of a recording, a second each, with what each of them tells; stretches are made of whole cells."""

from dataclasses import dataclass

import numpy as np

from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.thinning.coarse import Coarse, MotionRegressor
from ffgym.logs.quality.runs import stretches

CELL = 1.0
"""Length of a cell [s]; chosen: a block of the evidence."""

_REST = 0.1
"""Time [s] for which all joints rest where a cell is cut at rest; chosen: longer than joints that turn together are
slow."""

_PAUSE = 3.0
"""Interval of the clock [s] as which longer ones count: a cell lies in it, and a night takes no more memory."""

_THERE = 0.5
"""Share of its rows that a cell has at least; one with fewer lies in a pause of the clock."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Cells:
    """C cells of one recording, one after the other."""

    edges: Array
    """Where they begin and end [s], shape (C + 1,)."""
    at_rest: BoolArray
    """Whether the joints rest there, or the recording itself begins or ends, shape (C + 1,)."""
    information: Array
    """Products of the regressor's columns over each cell [s], shape (C, K, K)."""
    moving: Array
    """Share of each cell in which a joint moves, shape (C,)."""
    there: BoolArray
    """Cells that have their rows, shape (C,)."""

    def __len__(self) -> int:
        return len(self.moving)


def cells_of(motion: Coarse, regressor: MotionRegressor) -> Cells:
    """Cut a recording into cells, at rest where there is one within half a cell.

    Args:
        motion: of the recording.
        regressor: scaled to all recordings of the log.
    """
    period, t = motion.period, _without_pauses(motion.t)
    first, last = float(t[0] - period / 2), float(t[-1] + period / 2)
    count = max(1, int((last - first) / CELL))
    rests = regressor.rests(motion)
    edges, at_rest = np.linspace(first, last, count + 1), np.ones(count + 1, dtype=np.bool_)
    for k in range(1, count):
        near = slice(*np.searchsorted(t, (edges[k] - CELL / 2, edges[k] + CELL / 2)).tolist())
        runs = stretches(rests[near], max(1, round(_REST / period)))
        at_rest[k] = bool(runs)
        if runs:
            longest = max(runs, key=lambda rows: rows.stop - rows.start)
            edges[k] = t[near][(longest.start + longest.stop) // 2]
    rows, ends = regressor.rows(motion), np.searchsorted(t, edges)
    own = [slice(a, b) for a, b in zip(ends[:-1].tolist(), ends[1:].tolist(), strict=True)]
    there = period * np.array([cell.stop - cell.start for cell in own]) >= _THERE * np.diff(edges)
    edges[-1] += period  # the last rows may be too few for a coarse one
    pauses = np.interp(edges, t, motion.t - t)
    return Cells(
        edges=edges + pauses,
        at_rest=at_rest,
        information=period * np.stack([rows[cell].T @ rows[cell] for cell in own]),
        moving=np.array([1.0 - rests[cell].mean() if cell.stop > cell.start else 0.0 for cell in own]),
        there=there,
    )


def _without_pauses(t: Array) -> Array:
    """Times [s] with pauses of the clock shortened."""
    return np.asarray(t - np.concatenate([[0.0], np.cumsum(np.maximum(np.diff(t) - _PAUSE, 0.0))]))
