"""Checks of the values of a column: constant, stuck, clipped, coarse, missing."""

from collections.abc import Iterator

import numpy as np

from ffgym.quality.check import Check, NotJudgedError, Seen
from ffgym.quality.compare import compare
from ffgym.quality.log import Log
from ffgym.quality.runs import constant_stretches, grid_step, smallest_step
from ffgym.types import Array

_TORQUES = ("motor.effort", "command.effort", "feedback.effort", "feedback.integral")
_SENSED = ("motor.position", "motor.velocity", "link.position", "link.velocity", "motor.effort", "command.effort")
"""Families that change wherever their joint moves."""

_STUCK_ROWS = 8
"""Rows of one value from which on a column may be stuck; fewer are quantisation at low speed."""

_CAUGHT_UP = 0.5
"""Share of what set-points moved on during a stretch of one value by which a stuck column jumps at its end; a joint
that sticks by friction goes on from where it stood."""

_ABRUPT = 5.0
"""Steps of the resolution per row before a stretch of one value that a joint coming to rest does not have."""


_GRID = 10
"""Different positions from which on they say what their step is."""


def _joint_columns(log: Log, families: tuple[str, ...]) -> Iterator[tuple[str, int, str, Array]]:
    """Family, joint number, name and values of all per-joint columns of `families` that are present."""
    for family in families:
        if log.recording.has(family):
            for name, values in log.columns(family).items():
                yield family, log.joints.index(name.removeprefix(f"{family}.")), name, values


def _constant(log: Log) -> Iterator[Seen]:
    moved = _travels(log)
    if not moved.any():
        raise NotJudgedError("no joint moves")
    for _, j, name, x in _joint_columns(log, (*_SENSED, "reference.position")):
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
    for family, j, name, x in _joint_columns(log, _SENSED):
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
    edges = (x.min(), x.max()) if family in _TORQUES else ()
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


def _clipped(log: Log) -> Iterator[Seen]:
    for _, j, name, x in _joint_columns(log, _TORQUES):
        if np.ptp(x) == 0.0:
            continue
        share = sum(_plateau(x, edge) for edge in (x.max(), x.min())) / len(x)
        message = (
            f"{name} stays at {x.min():.4g} or {x.max():.4g} {log.recording.unit(name)}, its extremes, in {share:.2%} "
            "of all rows, must be below 0.1 %. It is cut there: widen the range of the measurement, or move more "
            "gently."
        )
        yield Seen(value=share, message=message, columns=(name,), joint=log.joints[j])


def _plateau(x: Array, edge: float) -> int:
    """Rows in which `x` stays at `edge` after it came there fast."""
    step, count = smallest_step(x), 0
    for rows in constant_stretches(x, 3):
        if x[rows.start] == edge:
            into = abs(x[rows.start] - x[rows.start - 1]) if rows.start else 0.0
            away = abs(x[rows.stop] - x[rows.stop - 1]) if rows.stop < len(x) else 0.0
            count += (rows.stop - rows.start) * (max(into, away) > 3 * step)
    return count


def _coarse(log: Log) -> Iterator[Seen]:
    for _, j, name, x in _joint_columns(log, ("motor.position", "link.position", "motor.effort")):
        if not log.excited[j] or np.ptp(x) == 0.0:
            continue
        share = grid_step(x) / float(np.ptp(x))
        message = (
            f"{name} has {1 / share if share else 0:.0f} steps of {share * np.ptp(x):.3g} {log.recording.unit(name)} "
            "in its range, must have at least 300. Log more digits or bits, or move farther."
        )
        yield Seen(value=share, message=message, columns=(name,), joint=log.joints[j])


def _encoder(log: Log) -> Iterator[Seen]:
    header = log.recording.header
    if header.encoder_bits is None or not log.recording.has("motor.position"):
        raise NotJudgedError("the header has no encoder_bits, or there is no motor.position")
    for _, j, name, x in _joint_columns(log, ("motor.position",)):
        gear = abs(header.gear_ratio[j]) if header.position_side == "link" else 1.0
        expected = 2 * np.pi / 2**header.encoder_bits / gear
        ratio = _encoder_ratio(x, expected)
        value = max(ratio, 1 / ratio) if ratio > 0 else 0.0
        message = (
            f"{name} goes in steps of {ratio * expected:.3g} rad, {ratio:.3g} times those of the {header.encoder_bits} "
            "bit of the header, must be the same. Log all bits, or correct encoder_bits."
        )
        yield Seen(value=value, message=message, columns=(name,), joint=log.joints[j])


def _encoder_ratio(x: Array, expected: float) -> float:
    """Step of `x` (T,) over that of an encoder; 0 if it has none.

    A fast motion skips most steps, so that not the smallest that it shows counts but what all have in common.
    """
    counts = (x - x[0]) / expected
    whole = np.round(counts)
    if np.all(np.abs(counts - whole) < 0.05) and len(np.unique(whole)) >= _GRID:
        return float(np.gcd.reduce(whole.astype(np.int64)))
    return grid_step(x) / expected


def _missing(log: Log) -> Iterator[Seen]:
    present = [name for name, values in log.recording.columns.items() if name.startswith(("tcp.", "temperature."))]
    if not present:
        raise NotJudgedError("there is no column that may miss samples")
    for name in present:
        rows = np.flatnonzero(np.isfinite(log.recording[name]))
        share = 1.0
        if len(rows) > 1:
            every = float(np.median(np.diff(rows)))
            share = max(0.0, 1.0 - len(rows) * every / len(log.t))
        message = (
            f"{name} misses {share:.1%} of its own samples (NaN), must miss less than 5 %. Look for an interrupted "
            "beam or a lost sensor, or leave the column out."
        )
        yield Seen(value=share, message=message, columns=(name,))


LEVELS = (
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
    Check(
        name="clipped",
        figure="Share of rows at the extremes of a torque",
        unit="1",
        flag=0.001,
        refuse=0.02,
        why="a cut torque is a wrong torque; a controller may saturate for a moment, not for a fiftieth of a log",
        judge=_clipped,
    ),
    Check(
        name="coarse",
        figure="Step over range",
        unit="1",
        flag=1 / 300,
        why="8 bits over the range are 256 steps: friction, some percent of the range, is then a few steps",
        judge=_coarse,
    ),
    Check(
        name="encoder_steps",
        figure="Step of the position over that of the header's encoder, or the other way round",
        unit="1",
        flag=1.5,
        why="half a step is rounding; more is another encoder, or digits lost on the way",
        judge=_encoder,
    ),
    Check(
        name="missing",
        figure="Share of missing samples",
        unit="1",
        flag=0.05,
        refuse=0.5,
        why="a tracker that loses its beam for a moment leaves the rest usable",
        judge=_missing,
    ),
)
"""Checks of levels."""
