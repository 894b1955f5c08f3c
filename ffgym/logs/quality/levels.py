"""Checks of the values of a column: clipped, coarse, missing."""

from collections.abc import Iterator

import numpy as np

from ffgym.core.types import Array
from ffgym.logs.quality.check import Check, NotJudgedError, Seen
from ffgym.logs.quality.families import TORQUES, joint_columns
from ffgym.logs.quality.log import Log
from ffgym.logs.quality.runs import constant_stretches, grid_step, smallest_step

_GRID = 10
"""Different positions from which on they say what their step is."""


def _clipped(log: Log) -> Iterator[Seen]:
    for _, j, name, x in joint_columns(log, TORQUES):
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
    for _, j, name, x in joint_columns(log, ("motor.position", "link.position", "motor.effort")):
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
    for _, j, name, x in joint_columns(log, ("motor.position",)):
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
