"""Checks of single rows: values that stick out, jumps, bursts of noise."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy

from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.logs.quality.check import ROWS, Seen, check
from ffgym.logs.quality.log import CheckedLog
from ffgym.logs.quality.signals import TINY, smallest_step

REACH = 10
"""Rows to either side that say what is usual: enough to know the noise, few enough to stay in one phase of a motion."""

SPIKE, _SPIKE_REFUSED = ROWS["spike"]["flag"], ROWS["spike"]["refuse"]
"""Excursion over the largest steps around it from which on a row is not of the machine, and of no machine."""

COMPUTED = ("feedforward.effort", "feedback.effort", "feedback.integral", "compensation.effort", "command.effort")
"""Families that a controller computed, which may do what no machine does: they are flagged, not refused."""

_FLOOR = 1e-3
"""Share of the range of a column that never counts as more than noise: what this check overlooks (docs/quality.md)."""

_NOISE = (0.95, 0.8)
"""Quantile of how far rows of a column stick out, and how many times that is usual anywhere in it: a spike then sticks
out by 7 standard deviations of a noise whose steps a coarse column hides around some rows."""

_ROUNDING = 1e-11
"""Share of a column's largest value that is no noise: set-points that a solver computed to 1e-12 err by as much where
they do not change, and more in some places than in others."""

_STEPS = 8
"""Steps that a column must have for the smallest to be its resolution: those of one spike are two."""

_CONTINUOUS = (
    *("motor.position", "link.position", "reference.position", "tcp.position", "tcp_reference.position"),
    *("motor.velocity", "link.velocity", "reference.velocity", "temperature"),
)
"""Families whose quantity cannot jump; torques may, with the sign of a speed."""

BURST = 64
"""Rows over which noise is measured."""

BURST_REFUSED = ROWS["noise_burst"]["refuse"]
"""Noise over the usual noise from which on it is none of the machine."""

_WHITE = 5.0
"""Energy of third over first differences from which on a window holds noise, not motion: it is 10 for white noise."""


def usual_steps(x: Array, resolution: float) -> Array:
    """Largest difference between neighbours within `REACH`, the two at the row itself left out; shape (T,).

    It is no less than the `resolution` of the column, and than `_FLOOR`.
    """
    return _largest_beside(x, REACH - 1, resolution)


def _largest_beside(x: Array, width: int, resolution: float) -> Array:
    """Largest of the `width` steps on either side: of rows for `REACH` - 1, of the steps between rows for `REACH`."""
    steps = np.concatenate([np.zeros(REACH), np.abs(np.diff(x)), np.zeros(REACH)])
    largest = scipy.ndimage.maximum_filter1d(steps, width)[width // 2 : width // 2 + len(steps) - width + 1]
    count = len(x) + REACH - 1 - width
    usual = np.maximum(largest[:count], largest[REACH + 1 : REACH + 1 + count])
    rounding = _ROUNDING * float(np.max(np.abs(x)))
    return np.maximum(usual, max(resolution, _FLOOR * float(np.ptp(x)), rounding, TINY))


def outlier_ratio(x: Array, resolution: float) -> Array:
    """Compute how far each row of `x` (T,) sticks out of both neighbours, over the usual value there; shape (T,)."""
    steps = np.diff(x)
    out = np.zeros(len(x))
    into, away = steps[:-1], -steps[1:]
    out[1:-1] = np.where(into * away > 0, np.minimum(np.abs(into), np.abs(away)), 0.0)
    out[:2] = 0.0  # a run may begin with a step of its servo
    out[-1] = min(abs(steps[-1]), abs(steps[-1] - steps[-2]))  # from the last row, and from where it led
    noise = _NOISE[1] * float(np.quantile(out, _NOISE[0]))
    return np.asarray(out / np.maximum(usual_steps(x, resolution), noise))


@dataclass(frozen=True, eq=False)
class CellColumn:
    """A column without its missing samples."""

    family: str
    name: str
    rows: IntArray
    """Rows that are not missing, shape (R,)."""
    values: Array
    """Shape (R,)."""
    resolution: float
    """Smallest step of the column, or of its family where it hardly changes."""


@lru_cache(maxsize=4)
def columns_of(log: CheckedLog) -> tuple[CellColumn, ...]:
    """Columns of the schema with samples enough; what columns of the user's own may do is not known."""
    found = []
    for family in log.families:
        if family in ("timestamp", "tcp.timestamp"):
            continue
        seen = {name: np.flatnonzero(np.isfinite(values)) for name, values in log.columns(family).items()}
        values = {name: log.recording[name][rows] for name, rows in seen.items()}
        steps = {name: smallest_step(x, _STEPS) for name, x in values.items()}
        for name, rows in seen.items():
            if len(rows) > 2 * REACH:
                found.append(CellColumn(family, name, rows, values[name], steps[name] or max(steps.values())))
    return tuple(found)


@check
def _spike(log: CheckedLog) -> Iterator[Seen]:
    for column in columns_of(log):
        ratio = outlier_ratio(column.values, column.resolution)
        worst = int(np.argmax(ratio))
        words = {"x": column.values[worst], "t": log.t[column.rows[worst]], "ratio": ratio[worst]}
        words["count"] = np.sum(ratio > SPIKE)
        value = min(float(ratio[worst]), _SPIKE_REFUSED) if column.family in COMPUTED else float(ratio[worst])
        yield Seen(value, (column.name,), log.joint_of(column.name), words)


@check
def _jump(log: CheckedLog) -> Iterator[Seen]:
    for column in columns_of(log):
        if column.family not in _CONTINUOUS:
            continue
        rows, x = column.rows, column.values
        ratio = np.abs(np.diff(x)) / _largest_beside(x, REACH, column.resolution)
        ratio[0] = 0.0  # a run may begin with a step of its servo
        ratio[np.diff(rows) > np.median(np.diff(rows))] = 0.0  # a longer way between samples that are not missing
        worst = int(np.argmax(ratio))
        words = {"step": x[worst + 1] - x[worst], "unit": log.recording.unit(column.name), "t": log.t[rows[worst]]}
        yield Seen(float(ratio[worst]), (column.name,), log.joint_of(column.name), words)


@check
def _noise_burst(log: CheckedLog) -> Iterator[Seen]:
    for column in columns_of(log):
        joint = log.joint_of(column.name)
        counts = log.recording.valid[:, log.joints.index(joint)] if joint else np.ones(len(log.t), dtype=np.bool_)
        ratios = burst_ratios(column, counts)
        if ratios.size:
            worst = int(np.argmax(ratios))
            yield Seen(float(ratios[worst]), (column.name,), joint, {"t": log.t[column.rows[worst * BURST]]})


def burst_ratios(column: CellColumn, counts: BoolArray) -> Array:
    """Noise of each `BURST` rows over that usual in a column; 0 where not all rows `counts` (T,); empty if short."""
    x = column.values
    if len(x) < 8 * BURST:
        return np.zeros(0)
    # standard deviation of white noise in each window, without spikes; 0 in motion
    count = (len(x) - 3) // BURST
    first, third = (np.diff(x, order)[: count * BURST].reshape(count, BURST) for order in (1, 3))
    white = np.mean(third**2, axis=1) > _WHITE * np.var(first, axis=1)
    levels = np.where(white, 1.4826 * np.median(np.abs(third), axis=1) / np.sqrt(20), 0.0)
    rounding = _ROUNDING * float(np.max(np.abs(x)))
    usual = max(float(np.median(levels)), column.resolution, _FLOOR * float(np.ptp(x)), rounding)
    known = counts[column.rows][: len(levels) * BURST].reshape(len(levels), BURST).all(axis=1)
    return np.where(known, levels / usual, 0.0) if usual else np.zeros_like(levels)
