"""Checks of whole rows and columns that are copies: repeated rows and blocks, one joint's column under two names."""

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from ffgym.core.types import Array, BoolArray
from ffgym.logs.quality.check import Check, NotJudgedError, Seen
from ffgym.logs.quality.log import Log
from ffgym.logs.quality.runs import smallest_step, stretches
from ffgym.recordings import FAMILIES
from ffgym.recordings.schema import VALID

_BLOCK = 5
"""Rows that must repeat one after the other to be a copied block."""

_CELLS = 40
"""Cells that such a block must have: a coarse position and its set-point alone repeat by chance for six rows."""

_ALIVE = 5.0
"""Steps of its resolution by which a column must change from row to row to be in motion."""

_DIFFERENT = 10
"""Values that two columns must share to be copies: encoders and noise at rest have some steps."""

_MEASURED = ("motor.position", "motor.velocity", "motor.effort", "link.position", "link.velocity", "feedback.effort")
"""Families in which no two joints are equal to the last bit."""


def _table(log: Log) -> Array:
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


def _alive(table: Array) -> BoolArray:
    """Where a row differs from the one before by more than `_ALIVE` steps in at least a third of all columns, (T,)."""
    resolution = np.array([smallest_step(column) for column in table.T])
    changes = np.abs(np.diff(table, axis=0, prepend=table[:1])) > _ALIVE * resolution
    return np.asarray(changes.mean(axis=1) > 1 / 3)


def _passing(log: Log, before: int, after: int) -> bool:
    """Whether a position goes on alike, by more than `_ALIVE` steps, into row `before` and out to row `after`.

    Noise in coarse columns repeats by chance where a joint turns round or rests; a joint on its way never does.
    """
    families = [name for name in log.motion_families if name.endswith("position")]
    for family in families:
        for x in log.columns(family).values():
            into, away = float(x[before] - x[before - 1]), float(x[after] - x[after - 1])
            if into * away > 0 and min(abs(into), abs(away)) > _ALIVE * smallest_step(x):
                return True
    return not families


def repeated_rows(log: Log) -> list[slice]:
    """Stretches of rows that repeat the row before them in motion.

    Raises:
        NotJudgedError: if nothing but the clock changes.
    """
    table = _table(log)
    equal = np.concatenate([[False], np.all(table[1:] == table[:-1], axis=1)])
    alive = _alive(table)
    return [
        rows
        for rows in stretches(equal)
        if rows.start >= 2
        and rows.stop < len(equal)
        and alive[rows.start - 1]
        and alive[rows.stop]
        and _passing(log, rows.start - 1, rows.stop)
    ]


def _repeated(log: Log) -> Iterator[Seen]:
    copies = repeated_rows(log)
    count = sum(rows.stop - rows.start for rows in copies)
    where = f", first at {log.t[copies[0].start]:.4g} s" if copies else ""
    message = (
        f"All columns: {count} rows repeat the row before while the robot moves{where}, must be none. Drop them; a "
        "logger that polls faster than the controller computes makes such rows."
    )
    yield Seen(value=float(count), message=message, columns=tuple(log.recording.columns))


def _blocks(log: Log) -> Iterator[Seen]:
    table = _table(log)
    longest, first, second = _longest_copy(table)
    if longest * table.shape[1] < _CELLS:
        longest = 0
    message = (
        f"All columns: {longest} rows from {log.t[second]:.4g} s on repeat those from {log.t[first]:.4g} s on to the "
        f"last bit, must be fewer than {_BLOCK}. Drop the copy."
    )
    yield Seen(value=float(longest), message=message, columns=tuple(log.recording.columns))


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


def _copied_columns(log: Log) -> Iterator[Seen]:
    for family in _MEASURED:
        if not log.recording.has(family):
            continue
        columns = log.columns(family)
        for (one, x), (other, y) in combinations(columns.items(), 2):
            same = _equal_share(x, y)
            message = (
                f"{one} and {other} are equal in {same:.0%} of the rows in which they change, must differ. One of them "
                "is a copy; export the log again."
            )
            yield Seen(value=same, message=message, columns=(one, other), joint=_joint(family, one))


def _equal_share(x: Array, y: Array) -> float:
    """Share of the rows in which `x` or `y` (T,) changes where they are equal; 0 if there are too few to tell.

    Joints that rest have equal values by chance, but not while they change, nor many of them.
    """
    changing = (np.diff(x) != 0) | (np.diff(y) != 0)
    equal = x[1:] == y[1:]
    if len(np.unique(x[1:][changing & equal])) < _DIFFERENT:
        return 0.0
    return float(equal[changing].mean())


def _joint(family: str, column: str) -> str:
    return column.removeprefix(family + ".") if FAMILIES[family].parts == "joint" else ""


ROWS = (
    Check(
        name="repeated_rows",
        figure="Rows that repeat the row before in motion",
        unit="rows",
        flag=0.0,
        refuse=10.0,
        why="a moving robot never gives the same row twice; each copy is a stop that was none",
        judge=_repeated,
    ),
    Check(
        name="repeated_block",
        figure="Longest block of rows that occurs twice",
        unit="rows",
        flag=_BLOCK - 1.0,
        refuse=_BLOCK - 1.0,
        why="noise and rounding never repeat over five changing rows; a block that does was pasted",
        judge=_blocks,
    ),
    Check(
        name="copied_column",
        figure="Share of the rows in which two joints change where they are equal",
        unit="1",
        flag=0.9,
        refuse=0.9,
        why="two joints that change are never equal to the last bit; joints that rest are",
        judge=_copied_columns,
    ),
)
"""Checks for copies."""
