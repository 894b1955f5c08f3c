"""Checks of the values of a column: stuck while its joint moves, clipped, coarse, missing."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import final

import numpy as np

from ffgym.core.types import Array
from ffgym.logs.quality.check import Seen, check
from ffgym.logs.quality.log import EXCITED, TORQUES, Log, NotJudgedError
from ffgym.logs.quality.signals import compare, constant_stretches, grid_step, smallest_step

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

_GRID = 10
"""Different positions from which on they say what their step is."""


@check
def _constant(log: Log) -> Iterator[Seen]:
    travel = [np.ptp(motion, axis=0) for motion in log.motions.values()]
    moved = np.max(travel, axis=0) > 1e-3 if travel else np.zeros(len(log.joints), dtype=np.bool_)
    if not moved.any():
        raise NotJudgedError("no joint moves")
    for _, j, name, x in log.joint_columns((*_SENSED, "command.effort", "reference.position")):
        words = {"first": x[0], "unit": log.recording.unit(name)}
        yield Seen(float(bool(moved[j] and np.ptp(x) == 0.0)), (name,), log.joints[j], words)


@check
def _stuck(log: Log) -> Iterator[Seen]:
    found = stuck_stretches(log)
    if not found:
        yield Seen(0.0)
    for stretch in found:
        start, stop = log.t[stretch.rows.start], log.t[stretch.rows.stop - 1]
        yield Seen(float(stop - start), (stretch.name,), log.joints[stretch.joint], {"start": start})


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
    for family, j, name, x in log.joint_columns(_SENSED):
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


@check
def _clipped(log: Log) -> Iterator[Seen]:
    for _, j, name, x in log.joint_columns(TORQUES):
        if np.ptp(x) == 0.0:
            continue
        share = sum(_plateau(x, edge) for edge in (x.max(), x.min())) / len(x)
        words = {"low": x.min(), "high": x.max(), "unit": log.recording.unit(name)}
        yield Seen(share, (name,), log.joints[j], words)


def _plateau(x: Array, edge: float) -> int:
    """Rows in which `x` stays at `edge` after it came there fast."""
    step, count = smallest_step(x), 0
    for rows in constant_stretches(x, 3):
        if x[rows.start] == edge:
            into = abs(x[rows.start] - x[rows.start - 1]) if rows.start else 0.0
            away = abs(x[rows.stop] - x[rows.stop - 1]) if rows.stop < len(x) else 0.0
            count += (rows.stop - rows.start) * (max(into, away) > 3 * step)
    return count


@check
def _coarse(log: Log) -> Iterator[Seen]:
    for _, j, name, x in log.joint_columns(("motor.position", "link.position", "motor.effort")):
        if log.excited[j] and np.ptp(x) > 0.0:
            share = grid_step(x) / float(np.ptp(x))
            words = {"steps": 1 / share if share else 0, "step": share * np.ptp(x), "unit": log.recording.unit(name)}
            yield Seen(share, (name,), log.joints[j], words)


@check
def _encoder_steps(log: Log) -> Iterator[Seen]:
    header = log.recording.header
    if header.encoder_bits is None or not log.recording.has("motor.position"):
        raise NotJudgedError("the header has no encoder_bits, or there is no motor.position")
    for _, j, name, x in log.joint_columns(("motor.position",)):
        gear = abs(header.gear_ratio[j]) if header.position_side == "link" else 1.0
        expected = 2 * np.pi / 2**header.encoder_bits / gear
        ratio = _encoder_ratio(x, expected)
        value = max(ratio, 1 / ratio) if ratio > 0 else 0.0
        yield Seen(value, (name,), log.joints[j], {"step": ratio * expected, "ratio": ratio})


def _encoder_ratio(x: Array, expected: float) -> float:
    """Step of `x` (T,) over that of an encoder; 0 if it has none.

    A fast motion skips most steps, so that not the smallest that it shows counts but what all have in common.
    """
    counts = (x - x[0]) / expected
    whole = np.round(counts)
    if np.all(np.abs(counts - whole) < 0.05) and len(np.unique(whole)) >= _GRID:
        return float(np.gcd.reduce(whole.astype(np.int64)))
    return grid_step(x) / expected


@check
def _missing(log: Log) -> Iterator[Seen]:
    present = [name for name in log.recording.columns if name.startswith(("tcp.", "temperature."))]
    if not present:
        raise NotJudgedError("there is no column that may miss samples")
    for name in present:
        rows, share = np.flatnonzero(np.isfinite(log.recording[name])), 1.0
        if len(rows) > 1:
            every = float(np.median(np.diff(rows)))
            share = max(0.0, 1.0 - len(rows) * every / len(log.t))
        yield Seen(share, (name,))
