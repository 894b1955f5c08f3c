"""Checks of the time base: unit, gaps, jumps, jitter, drift."""

from collections.abc import Iterator

import numpy as np

from ffgym.logs.quality.check import Check, NotJudgedError, Seen
from ffgym.logs.quality.intervals import longest_interval
from ffgym.logs.quality.log import Log

_COLUMNS = ("timestamp",)


def _unit(log: Log) -> Iterator[Seen]:
    message = (
        f"timestamp: rows are {log.dt:.4g} s apart, must be 0.5 s at most. If the clock counts milliseconds or "
        "microseconds, convert it to seconds."
    )
    yield Seen(value=log.dt, message=message, columns=_COLUMNS)


def _gaps(log: Log) -> Iterator[Seen]:
    """Rows that are missing, over rows that there should be; clock jumps, over which nothing moves, are not meant."""
    steps, moved = long_intervals(log)
    missing = np.round(np.diff(log.t)[steps] / log.dt) - 1
    missing = missing[moved]
    steps = steps[moved]
    share = missing.sum() / (len(log.t) + missing.sum())
    first = "" if not steps.size else f", the first after {log.t[steps[0]]:.4g} s"
    message = (
        f"timestamp: {missing.sum():.0f} rows are missing in {len(steps)} gaps ({share:.2%}{first}), must be none. "
        "Cut the log at the gaps, or record it again."
    )
    yield Seen(value=float(share), message=message, columns=_COLUMNS)


def _jumps(log: Log) -> Iterator[Seen]:
    steps, moved = long_intervals(log)
    jumps = steps[~moved]
    value = float(np.diff(log.t)[jumps].max() - log.dt) if jumps.size else 0.0
    where = f" after {log.t[jumps[0]]:.4g} s" if jumps.size else ""
    message = (
        f"timestamp: the clock jumps by {value:.4g} s{where} while the joints move on as in one sample of "
        f"{log.dt:.4g} s, must not jump. Repair the clock, or cut the log there."
    )
    yield Seen(value=value / log.dt, message=message, columns=_COLUMNS)


def long_intervals(log: Log) -> tuple[np.ndarray, np.ndarray]:
    """Rows before intervals that are too long, and whether the joints moved as far as their speed and the clock say."""
    steps = np.flatnonzero(np.diff(log.t) > longest_interval(log.t))
    moved = np.ones(len(steps), dtype=np.bool_)
    if log.q is None:
        return steps, moved
    for i, row in enumerate(steps):
        if 1 <= row < len(log.t) - 2:
            before, across, after = (log.q[k + 1] - log.q[k] for k in (row - 1, row, row + 1))
            speed = 0.5 * (before + after) / log.dt
            joint = int(np.argmax(np.abs(speed)))
            expected = speed[joint] * (log.t[row + 1] - log.t[row])
            one_sample = speed[joint] * log.dt
            moved[i] = abs(across[joint] - expected) <= abs(across[joint] - one_sample)
    return steps, moved


def _jitter(log: Log) -> Iterator[Seen]:
    intervals = np.diff(log.t)
    regular = intervals[intervals < longest_interval(log.t)]
    value = float(np.std(np.diff(regular)) / np.sqrt(2) / log.dt) if len(regular) > 1 else 0.0
    message = (
        f"timestamp: intervals scatter by {value:.1%} of {log.dt:.4g} s (rms), must be below 5 %. Use the clock of the "
        "controller, not the time at which a message arrived."
    )
    yield Seen(value=value, message=message, columns=_COLUMNS)


def _drift(log: Log) -> Iterator[Seen]:
    if len(log.t) < 200:
        raise NotJudgedError(f"{len(log.t)} rows are too few, 200 are needed")
    blocks = [float(np.median(block)) for block in np.array_split(np.diff(log.t), 10)]
    value = (max(blocks) - min(blocks)) / log.dt
    message = (
        f"timestamp: the sample time goes from {min(blocks):.6g} to {max(blocks):.6g} s, {value:.2%}, must stay within "
        "1 %. Join no logs of different rates; resample one of them."
    )
    yield Seen(value=value, message=message, columns=_COLUMNS)


CLOCK = (
    Check(
        name="clock_unit",
        figure="Sample time",
        unit="s",
        flag=0.5,
        refuse=0.5,
        why="a log of a motion with less than two samples a second shows no friction; one in milliseconds has them 1 "
        "to 100 apart",
        judge=_unit,
    ),
    Check(
        name="clock_jump",
        figure="Largest jump of the clock",
        unit="samples",
        flag=0.5,
        refuse=0.5,
        why="speeds across a jump are wrong; the joints tell it from missing rows, as they do not move meanwhile",
        judge=_jumps,
    ),
    Check(
        name="dropped_samples",
        figure="Share of missing rows",
        unit="1",
        flag=0.0,
        refuse=0.02,
        why="filters and derivatives take rows as even; a few gaps can be cut out, one row in fifty cannot",
        judge=_gaps,
    ),
    Check(
        name="clock_jitter",
        figure="Scatter of the intervals",
        unit="1",
        flag=0.05,
        refuse=0.3,
        why="a speed from differences is wrong by as much; beyond 30 % the rows are not samples of one rate",
        judge=_jitter,
    ),
    Check(
        name="clock_drift",
        figure="Change of the sample time",
        unit="1",
        flag=0.01,
        refuse=0.2,
        why="a quartz keeps 0.01 %; 1 % is another rate",
        judge=_drift,
    ),
)
"""Checks of the time base."""
