"""The choice of stretches: those that together tell most, spread over the whole log."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.diagnosis.thinning.cells import CELL, Cells

LENGTH = 10
"""Cells of a stretch: 10 s, as the motions of the protocol `diagnosis` last. Of longer ones there would be fewer, and
fewer could be left out in turn; of shorter ones filters and settling take too much."""

_WHOLE = 1.5
"""Lengths of a stretch up to which a recording is taken whole; what is left of it would be none."""

_SPREAD = 0.5
"""Share of the stretches that are spread evenly over the log, one in each part of it; the others lie where most is
told. Chosen: what changes in an hour is seen at some ten times."""

_MOVING = 0.25
"""Share of a stretch in which a joint moves, at least."""


@dataclass(frozen=True, kw_only=True)
class Selection:
    """A stretch that was chosen."""

    recording: int
    """Number of the recording."""
    first: int
    """Its first cell."""
    stop: int
    """The cell after its last one."""


def choose(log: Sequence[Cells], seconds: float) -> list[Selection]:
    r"""Choose stretches of recordings that last `seconds` at most, in their order.

    Stretches are chosen one after the other (D-optimality, greedy): the next one is that with which

    .. math:: \log \det \left( I + \sum X^T X \right)

    grows most, with the regressor X in units of a typical second. First one stretch is chosen in each of as many parts
    of the log as make up half of the time, then others anywhere. Of a part those count that begin and end at rest, if
    there are any: a replay begins at rest.

    Args:
        log: cells of all recordings.
        seconds: that are to be used.
    """
    windows = _Windows.of(log)
    left, chosen_at = seconds, np.zeros(len(windows.length), dtype=np.bool_)
    free, used = windows.usable.copy(), np.zeros(windows.n_cells, dtype=np.bool_)
    parts = max(1, round(_SPREAD * seconds / (CELL * LENGTH)))
    part_of = (2 * windows.begin + windows.length) * parts // (2 * windows.n_cells)
    served = np.zeros(parts, dtype=np.bool_)
    known = np.eye(windows.information.shape[1])
    while True:
        free &= (windows.lasting <= left) & ~windows.touches(used)
        wanted = _best_ends(windows, free & ~served[part_of], part_of)
        if not wanted.any():
            wanted = _best_ends(windows, free, np.zeros_like(part_of))
        if not wanted.any():
            break
        places = np.flatnonzero(wanted)
        best = int(places[np.argmax(np.linalg.slogdet(known + windows.information[places])[1])])
        known = known + windows.information[best]
        left -= float(windows.lasting[best])
        used[windows.begin[best] : windows.begin[best] + windows.length[best]] = True
        chosen_at[best], served[int(part_of[best])] = True, True
    return windows.choices(chosen_at)


def _best_ends(windows: "_Windows", allowed: BoolArray, part_of: IntArray) -> BoolArray:
    """Windows that are allowed and of which, in their part of the log, none has more ends at rest, shape (W,)."""
    wanted = np.zeros_like(allowed)
    for part in np.unique(part_of[allowed]):
        here = allowed & (part_of == part)
        wanted |= here & (windows.rests == windows.rests[here].max())
    return wanted


@dataclass(frozen=True, kw_only=True, eq=False)
class _Windows:
    """W stretches of which some are chosen, in the cells of all recordings, one recording after the other."""

    n_cells: int
    recording: IntArray
    """Recording of each window, shape (W,)."""
    begin: IntArray
    """Its first cell among those of all recordings."""
    first: IntArray
    """The same among those of its recording."""
    length: IntArray
    """Its cells."""
    lasting: Array
    """Time from its first edge to its last one [s]."""
    rests: IntArray
    """How many of its ends are at rest."""
    usable: BoolArray
    """Whether all its rows are there, and joints move."""
    information: Array
    """Products of the regressor's columns over it, shape (W, K, K)."""

    @classmethod
    def of(cls, log: Sequence[Cells]) -> "_Windows":
        """All windows of a log."""
        recording, begin, first, length, lasting, rests, there, moving, information = ([] for _ in range(9))
        before = 0
        for i, cells in enumerate(log):
            n = len(cells) if len(cells) <= _WHOLE * LENGTH else LENGTH
            total = np.cumsum(np.concatenate([np.zeros_like(cells.information[:1]), cells.information]), axis=0)
            for k in range(len(cells) - n + 1):
                recording.append(i)
                begin.append(before + k)
                first.append(k)
                length.append(n)
                lasting.append(float(cells.edges[k + n] - cells.edges[k]))
                rests.append(int(cells.at_rest[k]) + int(cells.at_rest[k + n]))
                there.append(bool(cells.there[k : k + n].all()))
                moving.append(float(cells.moving[k : k + n].mean()))
            information.append(total[n:] - total[:-n])
            before += len(cells)
        is_there, moves = np.array(there), np.array(moving) >= _MOVING
        return cls(
            n_cells=before,
            recording=np.array(recording),
            begin=np.array(begin),
            first=np.array(first),
            length=np.array(length),
            lasting=np.array(lasting),
            rests=np.array(rests),
            usable=is_there & moves if (is_there & moves).any() else is_there,
            information=np.concatenate(information),
        )

    def touches(self, used: BoolArray) -> BoolArray:
        """Windows that have a cell that is `used` (n_cells,), shape (W,)."""
        count = np.concatenate([[0], np.cumsum(used)])
        return np.asarray(count[self.begin + self.length] > count[self.begin])

    def choices(self, chosen_at: BoolArray) -> list[Selection]:
        """The windows that were chosen, in the order of the log."""
        return [
            Selection(
                recording=int(self.recording[w]),
                first=int(self.first[w]),
                stop=int(self.first[w] + self.length[w]),
            )
            for w in np.flatnonzero(chosen_at).tolist()
        ]
