"""Checks of whole rows: the clock, copies of rows and columns, what the mask leaves."""

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.logs.quality.check import Seen, check
from ffgym.logs.quality.log import CheckedLog, NotJudgedError
from ffgym.logs.quality.signals import longest_interval, smallest_step, stretches
from ffgym.recordings.schema import VALID

_CLOCK = ("timestamp",)

_CELLS = 40
"""Cells that a copied block must have: a coarse position and its set-point alone repeat by chance for six rows."""

_ALIVE = 5.0
"""Steps of its resolution by which a column must change from row to row to be in motion."""

_DIFFERENT = 10
"""Values that two columns must share to be copies: encoders and noise at rest have some steps."""

_MEASURED = ("motor.position", "motor.velocity", "motor.effort", "link.position", "link.velocity", "feedback.effort")
"""Families in which no two joints are equal to the last bit."""


@check
def _size(log: CheckedLog) -> Iterator[Seen]:
    for name, values in log.recording.columns.items():
        if name != "timestamp":
            words = {"name": name, "unit": log.recording.unit(name)}
            yield Seen(float(np.nanmax(np.abs(values), initial=0.0)), (name,), words=words)


@check
def _clock_unit(log: CheckedLog) -> Iterator[Seen]:
    yield Seen(log.dt, _CLOCK)


@check
def _clock_rate(log: CheckedLog) -> Iterator[Seen]:
    yield Seen(1 / log.dt, _CLOCK)


@check
def _dropped_samples(log: CheckedLog) -> Iterator[Seen]:
    """Rows that are missing, over rows that there should be; clock jumps, over which nothing moves, are not meant."""
    steps, moved = long_intervals(log)
    steps = steps[moved]
    rows = (np.round(np.diff(log.t)[steps] / log.dt) - 1).sum()
    first = "" if not steps.size else f", the first after {log.t[steps[0]]:.4g} s"
    yield Seen(float(rows / (len(log.t) + rows)), _CLOCK, words={"rows": rows, "gaps": len(steps), "first": first})


@check
def _clock_jump(log: CheckedLog) -> Iterator[Seen]:
    steps, moved = long_intervals(log)
    jumps = steps[~moved]
    jump = float(np.diff(log.t)[jumps].max() - log.dt) if jumps.size else 0.0
    where = f" after {log.t[jumps[0]]:.4g} s" if jumps.size else ""
    yield Seen(jump / log.dt, _CLOCK, words={"jump": jump, "where": where})


def long_intervals(log: CheckedLog) -> tuple[IntArray, BoolArray]:
    """Rows before intervals that are too long, and whether the joints moved as far as their speed and the clock say."""
    steps = np.flatnonzero(np.diff(log.t) > longest_interval(log.t))
    moved = np.ones(len(steps), dtype=np.bool_)
    for i, row in enumerate(steps):
        if 1 <= row < len(log.t) - 2:
            before, across, after = (log.q[k + 1] - log.q[k] for k in (row - 1, row, row + 1))
            speed = 0.5 * (before + after) / log.dt
            joint = int(np.argmax(np.abs(speed)))
            expected = speed[joint] * (log.t[row + 1] - log.t[row])
            one_sample = speed[joint] * log.dt
            moved[i] = abs(across[joint] - expected) <= abs(across[joint] - one_sample)
    return steps, moved


@check
def _clock_jitter(log: CheckedLog) -> Iterator[Seen]:
    intervals = np.diff(log.t)
    regular = intervals[intervals < longest_interval(log.t)]
    yield Seen(float(np.std(np.diff(regular)) / np.sqrt(2) / log.dt) if len(regular) > 1 else 0.0, _CLOCK)


@check
def _clock_drift(log: CheckedLog) -> Iterator[Seen]:
    if len(log.t) < 200:
        raise NotJudgedError(f"{len(log.t)} rows are too few, 200 are needed")
    blocks = [float(np.median(block)) for block in np.array_split(np.diff(log.t), 10)]
    low, high = min(blocks), max(blocks)
    yield Seen((high - low) / log.dt, _CLOCK, words={"low": low, "high": high})


def _table(log: CheckedLog) -> Array:
    """All columns but the clocks that change, side by side, (T, C); missing samples are zeros."""
    columns = [
        np.nan_to_num(values)
        for name, values in log.recording.columns.items()
        if name not in ("timestamp", "tcp.timestamp")
        and not name.startswith(f"{VALID}.")
        and np.nanmin(values, initial=0) != np.nanmax(values, initial=0)
    ]
    if not columns:
        raise NotJudgedError("nothing but the clock changes")
    return np.ascontiguousarray(np.stack(columns, axis=1) + 0.0)


def _passing(log: CheckedLog, before: int, after: int) -> bool:
    """Tell whether a position goes on alike, by more than `_ALIVE` steps, into row `before` and out to row `after`.

    Noise in coarse columns repeats by chance where a joint turns round or rests; a joint on its way never does.
    """
    families = [name for name in log.motion_families if name.endswith("position")]
    for family in families:
        for x in log.columns(family).values():
            into, away = float(x[before] - x[before - 1]), float(x[after] - x[after - 1])
            if into * away > 0 and min(abs(into), abs(away)) > _ALIVE * smallest_step(x):
                return True
    return not families


def copies(log: CheckedLog) -> list[slice]:
    """Stretches of rows that repeat the row before them in motion."""
    table = _table(log)
    equal = np.concatenate([[False], np.all(table[1:] == table[:-1], axis=1)])
    # rows that differ from the one before by more than `_ALIVE` steps in at least a third of all columns
    resolution = np.array([smallest_step(column) for column in table.T])
    alive = (np.abs(np.diff(table, axis=0, prepend=table[:1])) > _ALIVE * resolution).mean(axis=1) > 1 / 3
    inner = [rows for rows in stretches(equal) if rows.start >= 2 and rows.stop < len(equal)]
    between = [rows for rows in inner if alive[rows.start - 1] and alive[rows.stop]]
    return [rows for rows in between if _passing(log, rows.start - 1, rows.stop)]


@check
def _repeated_rows(log: CheckedLog) -> Iterator[Seen]:
    found = copies(log)
    where = f", first at {log.t[found[0].start]:.4g} s" if found else ""
    rows = sum(rows.stop - rows.start for rows in found)
    yield Seen(float(rows), tuple(log.recording.columns), words={"where": where})


@check
def _repeated_block(log: CheckedLog) -> Iterator[Seen]:
    table = _table(log)
    longest, first, second = _longest_copy(table)
    words = {"first": log.t[first], "second": log.t[second]}
    yield Seen(float(longest * (longest * table.shape[1] >= _CELLS)), tuple(log.recording.columns), words=words)


def _longest_copy(table: Array) -> tuple[int, int, int]:
    """Length, first row and copied first row of the longest block of changing rows that occurs again."""
    keys = table.view(np.dtype((np.void, table.dtype.itemsize * table.shape[1]))).ravel()
    _, group = np.unique(keys, return_inverse=True)
    order = np.argsort(group, kind="stable")
    follows = group[order[1:]] == group[order[:-1]]
    lag = np.zeros(len(table), dtype=np.int64)
    lag[order[1:][follows]] = (order[1:] - order[:-1])[follows]
    changing = np.concatenate([[True], group[1:] != group[:-1]])
    lag[~changing] = 0
    best = (0, 0, 0)
    for rows in stretches(lag > 0):
        values = lag[rows]
        for piece in np.split(np.arange(rows.start, rows.stop), np.flatnonzero(np.diff(values)) + 1):
            if len(piece) > best[0]:
                best = (len(piece), int(piece[0] - lag[piece[0]]), int(piece[0]))
    return best


@check
def _copied_column(log: CheckedLog) -> Iterator[Seen]:
    for family in _MEASURED:
        if log.recording.has(family):
            for (one, x), (other, y) in combinations(log.columns(family).items(), 2):
                # joints that rest have equal values by chance, but not while they change, nor many of them
                changing = (np.diff(x) != 0) | (np.diff(y) != 0)
                equal = x[1:] == y[1:]
                enough = len(np.unique(x[1:][changing & equal])) >= _DIFFERENT
                yield Seen(float(equal[changing].mean()) if enough else 0.0, (one, other), log.joint_of(one))


@check
def _masked(log: CheckedLog) -> Iterator[Seen]:
    shares = 1.0 - log.recording.valid.mean(axis=0)
    for joint, share in zip(log.joints, shares.tolist(), strict=True):
        yield Seen(share, (f"{VALID}.{joint}",), joint)


@check
def _nothing_left(log: CheckedLog) -> Iterator[Seen]:
    share = 1.0 - float(log.recording.valid.any(axis=1).mean())
    yield Seen(share, tuple(f"{VALID}.{joint}" for joint in log.joints))
