"""Checks for columns that keep one value while their joint moves."""

from collections.abc import Iterator

import numpy as np

from ffgym.quality.check import Check, NotJudgedError, Seen
from ffgym.quality.compare import compare
from ffgym.quality.families import TORQUES, joint_columns
from ffgym.quality.log import Log
from ffgym.quality.runs import constant_stretches, smallest_step
from ffgym.types import Array

_SENSED = ("motor.position", "motor.velocity", "link.position", "link.velocity", "motor.effort", "command.effort")
"""Families that change wherever their joint moves."""

_STUCK_ROWS = 8
"""Rows of one value from which on a column may be stuck; fewer are quantisation at low speed."""

_CAUGHT_UP = 0.5
"""Share of what set-points moved on during a stretch of one value by which a stuck column jumps at its end; a joint
that sticks by friction goes on from where it stood."""

_ABRUPT = 5.0
"""Steps of the resolution per row before a stretch of one value that a joint coming to rest does not have."""


def _constant(log: Log) -> Iterator[Seen]:
    moved = _travels(log)
    if not moved.any():
        raise NotJudgedError("no joint moves")
    for _, j, name, x in joint_columns(log, (*_SENSED, "reference.position")):
        alone = bool(moved[j] and np.ptp(x) == 0.0)
        message = (
            f"{name} is {x[0]:.4g} {log.recording.unit(name)} in all rows while joint {log.joints[j]} moves, must "
            "change. Log the signal, or leave the column out."
        )
        yield Seen(value=float(alone), message=message, columns=(name,), joint=log.joints[j])


def _travels(log: Log) -> np.ndarray:
    """Joints that move by any of their columns, (N,)."""
    travel = [np.ptp(motion, axis=0) for motion in log.motions.values()]
    return np.max(travel, axis=0) > 1e-3 if travel else np.zeros(len(log.joints), dtype=np.bool_)


def _stuck(log: Log) -> Iterator[Seen]:
    for family, j, name, x in joint_columns(log, _SENSED):
        if np.ptp(x) == 0.0:
            continue
        step = smallest_step(x)
        longest = max(
            (_stuck_time(log, family, j, x, step, rows), rows.start) for rows in [slice(0, 1), *_held(family, x)]
        )
        message = (
            f"{name} keeps one value for {longest[0]:.4g} s from {log.t[longest[1]]:.4g} s on while joint "
            f"{log.joints[j]} moves, must change. Look for a lost connection; cut the log there."
        )
        yield Seen(value=longest[0] / log.dt, message=message, columns=(name,), joint=log.joints[j])


def _held(family: str, x: Array) -> list[slice]:
    """Stretches of one value; not the extremes of a torque, at which it is cut rather than stuck."""
    edges = (x.min(), x.max()) if family in TORQUES else ()
    return [rows for rows in constant_stretches(x, _STUCK_ROWS) if x[rows.start] not in edges]


def _stuck_time(log: Log, family: str, j: int, x: Array, step: float, rows: slice) -> float:
    """How long a stretch of one value lasts [s]; 0 if it is a rest. `step` is the smallest step of `x`."""
    if rows.stop - rows.start < _STUCK_ROWS:
        return 0.0
    after = np.abs(np.diff(x[rows.stop - 1 : rows.stop + 2]))
    until_end = after.size == 0 and not family.endswith("position") and bool(log.moving[rows, j].mean() > 0.5)
    sudden = until_end or (after.size > 0 and bool(after.max() > _ABRUPT * step))
    if not ((sudden and _abrupt(x, step, rows.start)) or _others_move(log, family, j, rows)):
        return 0.0
    return float(log.t[rows.stop - 1] - log.t[rows.start])


def _abrupt(x: Array, step: float, row: int) -> bool:
    """Whether `x` (T,) comes to a row faster than a joint that comes to rest."""
    before = np.abs(np.diff(x[max(0, row - 3) : row + 1]))
    return before.size > 0 and bool(np.median(before) > _ABRUPT * step)


def _others_move(log: Log, family: str, j: int, rows: slice) -> bool:
    """Whether another column that otherwise goes like this one moves during a stretch of one value."""
    if not family.endswith("position") or family not in log.motions:
        return False
    own = log.motions[family][:, j]
    beside = [name for name in log.motions if name.endswith("position") and name != family]
    for name in beside:
        other = log.motions[name][:, j]
        moved = float(np.ptp(other[rows]))
        caught_up = not name.startswith("reference") or _jumps(own, rows.stop, _CAUGHT_UP * moved)
        if moved > 0.05 * log.travel[family][j] and caught_up and _alike(own, other, rows):
            return True
    return False


def _jumps(x: Array, row: int, least: float) -> bool:
    """Whether `x` (T,) comes to a row, if there is one, by a jump."""
    return row >= len(x) or abs(float(x[row] - x[row - 1])) > least


def _alike(a: Array, b: Array, without: slice) -> bool:
    """Whether two motions go alike, apart from a stretch of rows."""
    kept = np.ones(len(a) - 1, dtype=np.bool_)
    kept[max(0, without.start - 1) : without.stop] = False
    return kept.sum() > 2 and compare(np.diff(a)[kept], np.diff(b)[kept]).correlation > 0.8


STUCK = (
    Check(
        name="constant",
        figure="Columns of one value on a joint that moves",
        unit="1",
        flag=0.0,
        refuse=0.0,
        why="position, speed and torque of a moving joint change",
        judge=_constant,
    ),
    Check(
        name="stuck",
        figure="Longest stretch of one value in motion",
        unit="rows",
        flag=0.0,
        refuse=_STUCK_ROWS - 2.0,
        why="a stretch counts if it begins and ends abruptly, by 5 steps of the resolution and more, or if another "
        "position of the joint moves on by 5 % of its range; set-points move on beside a joint that sticks, so that "
        "the column must jump after them by half of that",
        judge=_stuck,
    ),
)
"""Checks for stuck columns."""
