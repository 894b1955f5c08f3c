"""Long logs thinned to the stretches that a diagnosis uses.

Its replays keep tens of arrays of samples, and its search hundreds of columns of rows that are compared. An hour of six
axes at 1 kHz, thinned to 83 s, takes 2.6 GB and two minutes on one core; of 120 s it takes 4 GB. More of them tell
hardly more: the protocol `diagnosis`, made to show every regime, lasts 88 s, and errors of sizes fall with the root of
the time alone.

A log that a diagnosis can afford is left as it is. Of a longer one stretches are cut, each of which is then a recording
of its own, with its place on the clock of the session: it is conditioned and judged alone, so that what is wrong in one
of them leaves the others. The choice looks at positions alone, on coarse rows, and does not depend on the order in
which recordings are given.
"""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.diagnosis.computing import on_one_thread
from ffgym.diagnosis.sampling import Sampling
from ffgym.diagnosis.settings import settings
from ffgym.diagnosis.thinning_cells import Cells, MotionRegressor, cut_cells, take_medians
from ffgym.recordings import Recording
from ffgym.recordings.io import Stored
from ffgym.recordings.stretch import Span, read_session_start, stretches_of


def choose_stretches(log: Sequence[Cells], seconds: float) -> list[tuple[int, int, int]]:
    r"""Choose stretches of recordings that last `seconds` at most.

    Stretches are chosen one after the other (D-optimality, greedy): the next one is that with which

    .. math:: \log \det \left( I + \sum X^T X \right)

    grows most, with the regressor X in units of a typical second. First one stretch is chosen in each of as many parts
    of the log as make up half of the time, then others anywhere. Of a part those count that begin and end at rest, if
    there are any: a replay begins at rest.

    Returns:
        Number of the recording, its first cell and the cell after the last one, in the order of the log.
    """
    limits = settings().blocks
    windows = _Windows.of(log)
    left, free = seconds, windows.usable.copy()
    chosen_at, used = np.zeros_like(free), np.zeros(windows.n_cells, dtype=np.bool_)
    # parts of the log of which each is to have one stretch
    parts = max(1, round(limits.spread_share * seconds / (limits.cell * limits.stretch)))
    part_of = (2 * windows.begin + windows.length) * parts // (2 * windows.n_cells)
    served = np.zeros(parts, dtype=np.bool_)
    known = np.eye(windows.information.shape[1])
    while True:
        # windows that are short enough and have no cell that is used
        count = np.concatenate([[0], np.cumsum(used)])
        free &= (windows.lasting <= left) & (count[windows.begin + windows.length] == count[windows.begin])
        wanted = _prefer_rests(windows, free & ~served[part_of], part_of)
        if not wanted.any():
            wanted = _prefer_rests(windows, free, np.zeros_like(part_of))
        if not wanted.any():
            break
        # of those the one that adds most information (D-optimality)
        places = np.flatnonzero(wanted)
        best = int(places[np.argmax(np.linalg.slogdet(known + windows.information[places])[1])])
        known = known + windows.information[best]
        left -= float(windows.lasting[best])
        used[windows.begin[best] : windows.begin[best] + windows.length[best]] = True
        chosen_at[best], served[int(part_of[best])] = True, True
    cells = np.stack([windows.recording, windows.first, windows.first + windows.length], axis=1)[chosen_at]
    return [(i, first, stop) for i, first, stop in cells.tolist()]


def _prefer_rests(windows: "_Windows", allowed: BoolArray, part_of: IntArray) -> BoolArray:
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
    """Number of its ends that are at rest."""
    usable: BoolArray
    """True if all its rows are there, and joints move."""
    information: Array
    """Products of the regressor's columns over it, shape (W, K, K)."""

    @classmethod
    def of(cls, log: Sequence[Cells]) -> "_Windows":
        """All windows of a log."""
        limits = settings().blocks
        whole, flags = list[list[int]](), list[Any]()
        lasting, information, before = list[float](), list[Array](), 0
        for i, cells in enumerate(log):
            # short recordings stay whole, longer ones are cut into windows of one length
            n = len(cells) if len(cells) <= limits.whole_stretches * limits.stretch else limits.stretch
            # information of each window as a difference of cumulative sums
            total = np.cumsum(np.concatenate([np.zeros_like(cells.information[:1]), cells.information]), axis=0)
            for k in range(len(cells) - n + 1):
                rests, inside = int(cells.at_rest[k]) + int(cells.at_rest[k + n]), slice(k, k + n)
                whole.append([i, before + k, k, n, rests])
                lasting.append(cells.edges[k + n] - cells.edges[k])
                flags.append([cells.there[inside].all(), cells.moving[inside].mean() >= limits.moving_share])
            information.append(total[n:] - total[:-n])
            before += len(cells)
        # windows of all recordings side by side, by cell of the whole log
        recording, begin, first, length, rest_ends = np.array(whole, dtype=np.intp).T
        there, moves = np.array(flags, dtype=np.bool_).T
        return cls(
            n_cells=before,
            recording=recording,
            begin=begin,
            first=first,
            length=length,
            lasting=np.array(lasting),
            rests=rest_ends,
            usable=there & moves if (there & moves).any() else there,
            information=np.concatenate(information),
        )


def compute_affordable_time(dt: float, n_joints: int) -> float:
    """Time [s] that all recordings of a log may last together before it is thinned."""
    limits = settings().blocks
    samples, rows = limits.samples / n_joints, limits.rows / n_joints
    stride = Sampling.of(dt, [round(samples)]).stride
    return min(samples, rows * stride) * dt


NOTE = "thinned"
"""Key of `meta` in the header of a stretch: a sentence on how the whole log was thinned."""


def read_notes(recordings: Sequence[Recording]) -> tuple[str, ...]:
    """Tell how a log was thinned that these are stretches of; empty if it was not."""
    return tuple(dict.fromkeys(str(one.header.meta[NOTE]) for one in recordings if NOTE in one.header.meta))


@on_one_thread
def thin(sources: Sequence[Recording | Stored]) -> list[Recording]:
    """Recordings in memory or in files, or if they are too long together for a diagnosis, stretches of them.

    Recordings of one machine have different names; else nothing is done, as the diagnosis refuses them.

    Raises:
        FFGymError: if one cannot be read.
    """
    lasting = [float(source.t[-1] - source.t[0]) for source in sources]
    names = [source.header.segment for source in sources]
    # time that all may last together: that of the fastest sample rate and the most joints
    periods, joints = [float(np.median(np.diff(one.t))) for one in sources], [len(one.header.joints) for one in sources]
    most = compute_affordable_time(min(periods), max(joints)) if sources else np.inf
    if len(set(names)) < len(names) or not sum(lasting) > most:
        return [source.whole() if isinstance(source, Stored) else source for source in sources]
    motions = [take_medians(source) for source in sources]

    # order by session, name and content, so that the order of the caller does not matter
    digests = [hashlib.sha256(b"".join(np.ascontiguousarray(x).tobytes() for x in (one.t, one.q))) for one in motions]
    order = sorted(
        range(len(sources)), key=lambda i: (read_session_start(sources[i].header), names[i], digests[i].digest())
    )
    # stretches of cells that tell most of the joints
    regressor = MotionRegressor.of([motions[i] for i in order])
    cells = [cut_cells(motions[i], regressor) for i in order]
    spans: list[list[Span]] = [[] for _ in sources]
    for i, first, stop in choose_stretches(cells, most):
        (start, end), (begins, ends) = cells[i].edges[[first, stop]].tolist(), cells[i].at_rest[[first, stop]].tolist()
        spans[order[i]].append(Span(start=start, end=end, at_rest=(begins, ends)))
    found = [part for source, own in zip(sources, spans, strict=True) if own for part in stretches_of(source, own)]
    # a sentence on how the log was thinned
    used, total = sum(float(one.t[-1] - one.t[0]) for one in found), sum(lasting)
    whole = "1 recording" if len(lasting) == 1 else f"{len(lasting)} recordings"
    text = (
        f"The log was thinned: {used:.0f} of {total:.0f} s are used, {len(found)} stretches of {whole} that are spread "
        "over all of it and tell most of the joints; more would take memory and time, and tell hardly more."
    )
    return [one.derive(one.columns, replace(one.header, meta=one.header.meta | {NOTE: text})) for one in found]
