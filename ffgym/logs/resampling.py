"""Samples that come at other times than the rows of a recording."""

from typing import NamedTuple

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array, BoolArray
from ffgym.logs.column_map.column import Resample

DONE = {
    "gaps": "samples of another clock, each put into the nearest row",
    "linear": "samples of another clock, interpolated linearly",
    "hold": "samples of another clock, held until the next",
}
"""What is said in the header about resampled columns."""


class Resampled(NamedTuple):
    """Samples at the rows."""

    samples: Array
    """Shape (T, P), NaN where there is none."""
    reached: BoolArray
    """Rows between the first sample and the last, shape (T,)."""


def resample(samples: Array, clock: Array, t: Array, how: Resample) -> Resampled:
    """Samples (C, P) taken at the times `clock` (C,) [s], at the rows `t` (T,) [s]; `how` as COLUMN_KEYS says.

    Raises:
        FFGymError: if there is not one time per sample, or the times do not increase.
    """
    if clock.shape != samples.shape[:1]:
        raise FFGymError(f"its clock has {clock.size} times for {len(samples)} samples.")
    if len(clock) < 2 or len(t) < 2:
        raise FFGymError(f"has {len(clock)} samples for {len(t)} rows; to resample takes at least 2 of each.")
    stalled = np.flatnonzero(~(np.diff(clock) > 0))
    if stalled.size:
        row = int(stalled[0]) + 1
        raise FFGymError(f"its clock must increase, but sample {row} is at {clock[row]} s after {clock[row - 1]} s.")
    methods = {"gaps": _nearest, "linear": _linear, "hold": _held}
    return methods[how](samples, clock, t)


def _nearest(samples: Array, clock: Array, t: Array) -> Resampled:
    """Each sample goes into the row nearest to it, if that is within half a period; of several the nearest stays."""
    after = np.clip(np.searchsorted(t, clock), 1, len(t) - 1)
    row = np.where(clock - t[after - 1] <= t[after] - clock, after - 1, after)
    distance = np.abs(clock - t[row])
    farthest_first = np.argsort(-distance, kind="stable")
    placed = farthest_first[distance[farthest_first] <= float(np.median(np.diff(t))) / 2]
    at_rows = np.full((len(t), samples.shape[1]), np.nan)
    at_rows[row[placed]] = samples[placed]  # the last of several, which is the nearest
    return Resampled(at_rows, np.ones(len(t), dtype=np.bool_))


def _linear(samples: Array, clock: Array, t: Array) -> Resampled:
    columns = [np.interp(t, clock, column, left=np.nan, right=np.nan) for column in samples.T]
    return Resampled(np.stack(columns, axis=1), (t >= clock[0]) & (t <= clock[-1]))


def _held(samples: Array, clock: Array, t: Array) -> Resampled:
    """The last one is held no longer than the longest of the others: after that the source has fallen silent."""
    last = np.searchsorted(clock, t, side="right") - 1
    reached = (last >= 0) & (t <= clock[-1] + np.max(np.diff(clock)))
    return Resampled(np.where(reached[:, None], samples[last], np.nan), reached)
