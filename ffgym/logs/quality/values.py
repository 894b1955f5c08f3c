"""Checks of the values of a column: stuck while its joint moves, clipped, coarse, missing."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ffgym.core.types import Array
from ffgym.logs.quality.check import Seen, check
from ffgym.logs.quality.log import EXCITED, TORQUES, CheckedLog, NotJudgedError
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

_ALIKE = 0.8
"""Correlation of the steps of two columns from which on they go alike."""

_ABRUPT = 5.0
"""Steps of the resolution in a third of `_BEFORE`, before a stretch of one value that begins abruptly."""

_GRID = 10
"""Different positions from which on they say what their step is."""


@check
def _constant(log: CheckedLog) -> Iterator[Seen]:
    travel = [np.ptp(motion, axis=0) for motion in log.motions.values()]
    moved = np.max(travel, axis=0) > 1e-3 if travel else np.zeros(len(log.joints), dtype=np.bool_)
    if not moved.any():
        raise NotJudgedError("no joint moves")
    for _, j, name, x in log.joint_columns((*_SENSED, "command.effort", "reference.position")):
        words = {"first": x[0], "unit": log.recording.unit(name)}
        yield Seen(float(bool(moved[j] and np.ptp(x) == 0.0)), (name,), log.joints[j], words)


@check
def _stuck(log: CheckedLog) -> Iterator[Seen]:
    found = stuck_stretches(log)
    if not found:
        yield Seen(0.0)
    for stretch in found:
        start, stop = log.t[stretch.rows.start], log.t[stretch.rows.stop - 1]
        yield Seen(float(stop - start), (stretch.name,), log.joints[stretch.joint], {"start": start})


@dataclass(frozen=True)
class Stretch:
    """Rows in which a column is stuck."""

    name: str
    joint: int
    rows: slice


def stuck_stretches(log: CheckedLog) -> list[Stretch]:
    """Columns that keep one value while their joint moves on, and where."""
    found = []
    for family, j, name, x in log.joint_columns(_SENSED):
        if np.ptp(x) > 0.0:
            step = smallest_step(x)
            # a column that is written more seldom than the rows keeps each value for some: a stretch must be longer
            every = np.diff(np.flatnonzero(np.diff(x) != 0))
            usual = float(np.quantile(every, _USUAL)) if every.size else 0.0
            held = constant_stretches(x, max(_STUCK_ROWS, log.rows(_STUCK_TIME), int(_LONGER * usual)))
            # at its extremes a torque is cut rather than stuck
            edges = (x.min(), x.max()) if family in TORQUES else ()
            held = [rows for rows in held if x[rows.start] not in edges]
            found += [Stretch(name, j, rows) for rows in held if _is_stuck(log, family, j, x, step, rows)]
    return found


def _is_stuck(log: CheckedLog, family: str, j: int, x: Array, step: float, rows: slice) -> bool:
    """Tell whether a stretch of one value in `x` (T,) is no rest. `step` is the resolution of `x`.

    A joint that comes to rest, or sticks by friction, goes on from where it stood; a position that is stuck jumps to
    where the joint is by then. Speeds and torques of a joint that moves change.
    """
    if _others_move(log, family, j, rows):
        return True
    if not _abrupt(log, x, step, rows.start):
        return False
    if family.endswith("position"):
        after = np.abs(np.diff(x[rows.stop : rows.stop + 6])).max(initial=0.0)
        return rows.stop < len(x) and _jumps(x, rows.stop, max(_ABRUPT * step, _JUMP * float(after)))
    moves = bool(log.moving[rows, j].mean() > 0.5)
    return moves and (rows.stop >= len(x) or _abrupt(log, x[::-1], step, len(x) - rows.stop))


def _abrupt(log: CheckedLog, x: Array, step: float, row: int) -> bool:
    """Tell whether `x` (T,) comes to a row faster than a joint that comes to rest: by steps of the resolution."""
    width = max(3, log.rows(_BEFORE))
    if row < width:
        return False
    usual = float(np.quantile(np.abs(x[width:] - x[:-width]), _TOP))
    return float(np.ptp(x[row - width : row + 1])) > max(3 * _ABRUPT * step, _SHARE * usual)


def _others_move(log: CheckedLog, family: str, j: int, rows: slice) -> bool:
    """Tell whether another column that otherwise goes like this one moves during a stretch of one value."""
    if not family.endswith("position") or family not in log.motions:
        return False
    own = log.motions[family][:, j]
    apart = np.ones(len(own) - 1, dtype=np.bool_)  # from the stretch
    apart[max(0, rows.start - 1) : rows.stop] = False
    beside = [name for name in log.motions if name.endswith("position") and name != family]
    for name in beside:
        other = log.motions[name][:, j]
        moved = float(np.ptp(other[rows]))
        caught_up = not name.startswith("reference") or _jumps(own, rows.stop, _CAUGHT_UP * moved)
        least = max(0.05 * log.travel[family][j], EXCITED)
        steps = np.diff(own)[apart], np.diff(other)[apart]
        if moved > least and caught_up and apart.sum() > 2 and compare(*steps).correlation > _ALIKE:
            return True
    return False


def _jumps(x: Array, row: int, least: float) -> bool:
    """Tell whether `x` (T,) comes to a row, if there is one, by a jump."""
    return row >= len(x) or abs(float(x[row] - x[row - 1])) > least


@check
def _clipped(log: CheckedLog) -> Iterator[Seen]:
    for _, j, name, x in log.joint_columns(TORQUES):
        if np.ptp(x) == 0.0:
            continue
        # rows that stay at an extreme after the torque came there, or before it left, fast
        step, edges, count = smallest_step(x), (x.min(), x.max()), 0
        for rows in constant_stretches(x, 3):
            into = abs(x[rows.start] - x[rows.start - 1]) if rows.start else 0.0
            away = abs(x[rows.stop] - x[rows.stop - 1]) if rows.stop < len(x) else 0.0
            if x[rows.start] in edges and max(into, away) > 3 * step:
                count += rows.stop - rows.start
        share = count / len(x)
        words = {"low": x.min(), "high": x.max(), "unit": log.recording.unit(name)}
        yield Seen(share, (name,), log.joints[j], words)


@check
def _coarse(log: CheckedLog) -> Iterator[Seen]:
    for _, j, name, x in log.joint_columns(("motor.position", "link.position", "motor.effort")):
        if log.excited[j] and np.ptp(x) > 0.0:
            share = grid_step(x) / float(np.ptp(x))
            words = {"steps": 1 / share if share else 0, "step": share * np.ptp(x), "unit": log.recording.unit(name)}
            yield Seen(share, (name,), log.joints[j], words)


@check
def _encoder_steps(log: CheckedLog) -> Iterator[Seen]:
    header = log.recording.header
    if header.encoder_bits is None or not log.recording.has("motor.position"):
        raise NotJudgedError("the header has no encoder_bits, or there is no motor.position")
    for _, j, name, x in log.joint_columns(("motor.position",)):
        gear = abs(header.gear_ratio[j]) if header.position_side == "link" else 1.0
        expected = 2 * np.pi / 2**header.encoder_bits / gear
        # a fast motion skips most steps, so that not the smallest that it shows counts but what all have in common
        counts = (x - x[0]) / expected
        whole = np.round(counts)
        on_grid = bool(np.all(np.abs(counts - whole) < 0.05)) and len(np.unique(whole)) >= _GRID
        ratio = float(np.gcd.reduce(whole.astype(np.int64))) if on_grid else grid_step(x) / expected
        value = max(ratio, 1 / ratio) if ratio > 0 else 0.0
        yield Seen(value, (name,), log.joints[j], {"step": ratio * expected, "ratio": ratio})


@check
def _missing(log: CheckedLog) -> Iterator[Seen]:
    present = [name for name in log.recording.columns if name.startswith(("tcp.", "temperature."))]
    if not present:
        raise NotJudgedError("there is no column that may miss samples")
    for name in present:
        rows, share = np.flatnonzero(np.isfinite(log.recording[name])), 1.0
        if len(rows) > 1:
            every = float(np.median(np.diff(rows)))
            share = max(0.0, 1.0 - len(rows) * every / len(log.t))
        yield Seen(share, (name,))
