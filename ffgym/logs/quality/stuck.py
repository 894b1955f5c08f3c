"""Checks for columns that keep one value while their joint moves."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import final

import numpy as np

from ffgym.core.types import Array
from ffgym.logs.quality.check import Check, NotJudgedError, Seen
from ffgym.logs.quality.compare import compare
from ffgym.logs.quality.families import TORQUES, joint_columns
from ffgym.logs.quality.log import EXCITED, Log
from ffgym.logs.quality.runs import constant_stretches, smallest_step

_SENSED = ("motor.position", "motor.velocity", "link.position", "link.velocity", "motor.effort")
"""Families that are measured, and change wherever their joint moves."""

_STUCK_ROWS, _STUCK_TIME = 8, 0.02
"""Rows and time [s] of one value from which on a column may be stuck; fewer are quantisation at low speed, shorter is
what low-passes bridge."""

_USUAL, _LONGER = 0.9, 4.0
"""Quantile of the times for which a column keeps its values, and how many times that is no slow column any more."""

_BEFORE = 0.005
"""Time [s] over which it counts how fast a column comes to a stretch of one value, three rows at least."""

_TOP, _SHARE = 0.95, 0.2
"""Quantile of the changes of a column over that time that is its top speed, and the share of it that is abrupt."""

_JUMP = 3.0
"""Step at the end of a stretch over the steps that follow, from which on it is a jump and no joint that goes on."""

_CAUGHT_UP = 0.5
"""Share of what set-points moved on during a stretch of one value by which a stuck column jumps at its end; a joint
that sticks by friction goes on from where it stood."""

_ABRUPT = 5.0
"""Steps of the resolution in a third of `_BEFORE`, before a stretch of one value that begins abruptly."""


def _constant(log: Log) -> Iterator[Seen]:
    moved = _travels(log)
    if not moved.any():
        raise NotJudgedError("no joint moves")
    for _, j, name, x in joint_columns(log, (*_SENSED, "command.effort", "reference.position")):
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
    found = stuck_stretches(log)
    if not found:
        yield Seen(value=0.0, message="")
    for stretch in found:
        held = float(log.t[stretch.rows.stop - 1] - log.t[stretch.rows.start])
        joint = log.joints[stretch.joint]
        message = (
            f"{stretch.name} keeps one value for {held:.4g} s from {log.t[stretch.rows.start]:.4g} s on while joint "
            f"{joint} moves, must change. Look for a lost connection."
        )
        yield Seen(value=held, message=message, columns=(stretch.name,), joint=joint)


@final
@dataclass(frozen=True)
class Stretch:
    """Rows in which a column is stuck."""

    name: str
    joint: int
    rows: slice


def stuck_stretches(log: Log) -> list[Stretch]:
    """Columns that keep one value while their joint moves on, and where."""
    found = []
    for family, j, name, x in joint_columns(log, _SENSED):
        if np.ptp(x) > 0.0:
            step = smallest_step(x)
            held = _held(log, family, x)
            found += [Stretch(name, j, rows) for rows in held if _is_stuck(log, family, j, x, step, rows)]
    return found


def _held(log: Log, family: str, x: Array) -> list[slice]:
    """Long stretches of one value; not the extremes of a torque, at which it is cut rather than stuck.

    A column that is written more seldom than the rows keeps each value for some rows: a stretch must be longer.
    """
    edges = (x.min(), x.max()) if family in TORQUES else ()
    every = np.diff(np.flatnonzero(np.diff(x) != 0))
    usual = float(np.quantile(every, _USUAL)) if every.size else 0.0
    shortest = max(_STUCK_ROWS, log.rows(_STUCK_TIME), int(_LONGER * usual))
    return [rows for rows in constant_stretches(x, shortest) if x[rows.start] not in edges]


def _is_stuck(log: Log, family: str, j: int, x: Array, step: float, rows: slice) -> bool:
    """Whether a stretch of one value in `x` (T,) is no rest. `step` is the resolution of `x`.

    A joint that comes to rest, or sticks by friction, goes on from where it stood; a position that is stuck jumps to
    where the joint is by then. Speeds and torques of a joint that moves change.
    """
    if _others_move(log, family, j, rows):
        return True
    if not _abrupt(log, x, step, rows.start):
        return False
    if family.endswith("position"):
        return rows.stop < len(x) and _jumps(x, rows.stop, max(_ABRUPT * step, _JUMP * _largest_step(x, rows.stop)))
    moves = bool(log.moving[rows, j].mean() > 0.5)
    return moves and (rows.stop >= len(x) or _abrupt(log, x[::-1], step, len(x) - rows.stop))


def _abrupt(log: Log, x: Array, step: float, row: int) -> bool:
    """Whether `x` (T,) comes to a row faster than a joint that comes to rest: by steps of the resolution, in a time."""
    width = max(3, log.rows(_BEFORE))
    if row < width:
        return False
    usual = float(np.quantile(np.abs(x[width:] - x[:-width]), _TOP))
    return float(np.ptp(x[row - width : row + 1])) > max(3 * _ABRUPT * step, _SHARE * usual)


def _largest_step(x: Array, row: int) -> float:
    """Largest step of `x` (T,) just after a row."""
    steps = np.abs(np.diff(x[row : row + 6]))
    return float(steps.max()) if steps.size else 0.0


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
        least = max(0.05 * log.travel[family][j], EXCITED)
        if moved > least and caught_up and _alike(own, other, rows):
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
        unit="s",
        flag=0.0,
        refuse=0.0,
        why="a stretch counts from 20 ms on, beyond 4 of the times for which the column keeps its values, if another "
        "position of the joint moves on by 1 mrad and 5 % of its range, or if it begins abruptly, by 15 steps of the "
        "resolution and a fifth of its usual top speed in 5 ms, and ends so; a position must jump to where the joint "
        "is by then: one that sticks by friction goes on from where it stood",
        judge=_stuck,
    ),
)
"""Checks for stuck columns."""
