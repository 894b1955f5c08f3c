"""Recordings from the arrays of a file, as a column map says."""

from bisect import bisect_left
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ffgym.core.errors import FFGymError, errors_at
from ffgym.core.types import Array, BoolArray
from ffgym.logs.column import Resample, conversion
from ffgym.logs.column_map import ColumnMap
from ffgym.logs.contents import Contents
from ffgym.logs.entries import TIMESTAMP, Entries, Entry, entries_of, place_of
from ffgym.logs.motions import LoggedMotion, motions_of
from ffgym.logs.si import to_kept_side, to_si
from ffgym.recordings import Header, Recording

_BACK = 0.01
"""Share of the rows that may go back in time; a clock that does so more often, or starts again, is none."""

_DONE = {
    "gaps": "samples of another clock, each put into the nearest row",
    "linear": "samples of another clock, interpolated linearly",
    "hold": "samples of another clock, held until the next",
}
"""Sentences for the header about resampled columns."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Rows:
    """The rows of one motion in time."""

    t: Array
    """Times [s], shape (T,)."""
    unit: str
    """Unit of their clock in the file."""
    zero: Any = None
    """Reading of that clock at which times begin, None for its own zero."""

    def seconds(self, clock: NDArray[Any], unit: str) -> Array:
        """Times [s] of another clock of the same epoch, on the scale of `t`."""
        factor = conversion(unit, "s").factor
        if self.zero is None:
            return clock.astype(np.float64) * factor
        if unit == self.unit:
            return since(clock, self.zero).astype(np.float64) * factor
        return clock.astype(np.float64) * factor - float(self.zero) * conversion(self.unit, "s").factor


def recordings_of(contents: Contents, columns: ColumnMap, header: Header) -> list[Recording]:
    """Recordings of all motions in a file; the segment of `header` names a single one, and begins names of several."""
    entries = entries_of(contents, columns, header)
    # the units of the user's columns, and what was done or left out on the way
    units: dict[str, str] = {}
    filters = list(header.filters)
    for key, entry in entries.others.items():
        if entry.target.family is None:
            with errors_at(place_of(key)):
                units |= zip(entry.target.columns, entry.target.units(header, entry.column), strict=True)
        if entry.column.resample:
            filters.append(f"{key}: {_DONE[entry.column.resample]}")
    left_out = {"left_out": entries.left_out} if entries.left_out else {}
    header = replace(header, units=units, filters=tuple(filters), provenance={**header.provenance, **left_out})
    motions = motions_of(contents, columns, header.segment, entries.arrays)
    return [_recording(contents, columns, entries, header, motion) for motion in motions]


def _recording(
    contents: Contents, columns: ColumnMap, entries: Entries, header: Header, motion: LoggedMotion
) -> Recording:
    """Recording of one motion."""
    with errors_at(place_of(TIMESTAMP)):
        every = _rows(contents, entries, motion)
    ordered = _increasing(every.t)
    rows = every if ordered.all() else replace(every, t=every.t[ordered])
    table = {TIMESTAMP: rows.t}
    reached: BoolArray = np.ones(len(rows.t), dtype=np.bool_)
    for key, entry in entries.others.items():
        with errors_at(place_of(key)):
            samples, within = _at_rows(contents, entry, header, motion, rows, ordered)
            if not (columns.trim or entry.target.may_miss or within.all()):
                raise FFGymError(
                    f"has no sample for {np.sum(~within)} of {len(within)} rows, the first of them "
                    f"{int(np.argmin(within))}. trim = true in [log] drops rows before and after the samples."
                )
            kept = to_kept_side(samples, entry.target, entry.column, header)
        reached &= within
        table |= dict(zip(entry.target.columns, kept.T, strict=True))
    notes = {} if ordered.all() else {"conditioning": [_order_note(every.t, ordered)]}
    header = replace(header, segment=motion.segment, meta={**header.meta, **motion.meta, **notes})
    if columns.trim:
        table = {name: values[reached] for name, values in table.items()}
    return Recording(table, header)


def _at_rows(
    contents: Contents, entry: Entry, header: Header, motion: LoggedMotion, rows: Rows, ordered: BoolArray
) -> tuple[Array, BoolArray]:
    """SI numbers of an entry on the side of the file, (T, P), for those rows of the file that are `ordered`.

    Beside them are the rows that lie between the first sample and the last, (T,).
    """
    column = entry.column
    values = motion.of(entry.values) if entry.clock is None else motion.uncut(entry.values)
    if column.from_first:
        samples = rows.seconds(values, str(column.unit))
    else:
        samples = to_si(values, column, entry.target.units(header, column), contents)
    if entry.clock is not None:
        clock = rows.seconds(motion.uncut(entry.clock)[:, 0], column.clock_unit or rows.unit)
        return resample(samples, clock, rows.t, column.resample)
    if len(samples) != len(ordered):
        raise FFGymError(
            f"has {len(samples)} rows, but timestamp has {len(ordered)}. Samples of another clock need clock and "
            "resample."
        )
    return samples[ordered], np.ones(len(rows.t), dtype=np.bool_)


def _increasing(t: Array) -> BoolArray:
    """Rows to keep so that times (T,) increase: most of them, the first of equal ones; all where too many go back."""
    everything = np.ones(len(t), dtype=np.bool_)
    if not np.isfinite(t).all() or bool(np.all(np.diff(t) > 0)):
        return everything
    kept = _longest_increasing(t)
    return everything if _back(t, kept) > max(1.0, _BACK * len(t)) else kept


def _order_note(t: Array, kept: BoolArray) -> str:
    """Say in a sentence which rows were left out."""
    back = _back(t, kept)
    twice = int((~kept).sum()) - back
    texts = [
        f"{n} {what}" for n, what in ((twice, "with the time of another row"), (back, "that go back in time")) if n
    ]
    return f"Rows of the file were dropped: {' and '.join(texts)}, the first in row {int(np.argmin(kept))}."


def _back(t: Array, kept: BoolArray) -> int:
    """Rows that are not `kept` (T,) and do not have the time of the kept row before them either."""
    last = np.maximum.accumulate(np.where(kept, np.arange(len(t)), 0))
    return int((~kept & (t != t[last])).sum())


def _longest_increasing(t: Array) -> BoolArray:
    """Rows of the longest increasing subsequence, by patience sorting; of equal times the first."""
    ends: list[float] = []
    rows: list[int] = []
    before = np.full(len(t), -1)
    for row, time in enumerate(t.tolist()):
        place = bisect_left(ends, time)
        if place < len(ends) and ends[place] == time:
            continue  # the first of equal times stays
        before[row] = rows[place - 1] if place else -1
        ends[place : place + 1] = [time]
        rows[place : place + 1] = [row]
    kept = np.zeros(len(t), dtype=np.bool_)
    row = rows[-1]
    while row >= 0:
        kept[row] = True
        row = int(before[row])
    return kept


def _rows(contents: Contents, entries: Entries, motion: LoggedMotion) -> Rows:
    """Rows of a motion: at the readings of their clock, or at a constant rate from 0 on."""
    timestamp = entries.timestamp
    if entries.times is not None:
        clock = motion.of(entries.times)
        zero = clock[0, 0] if timestamp.from_first and len(clock) else None
        readings = clock if zero is None else since(clock, zero)
        return Rows(t=to_si(readings, timestamp, ("s",), contents)[:, 0], unit=str(timestamp.unit), zero=zero)
    rate = timestamp.rate_hz
    numbers = contents.numbers(rate).reshape(-1) if isinstance(rate, str) else np.array([rate])
    if numbers.size != 1 or not 0 < numbers[0] < np.inf:
        raise FFGymError(f"rate_hz = {numbers.tolist()[:3]} must be one number > 0.")
    first = next(entry for entry in entries.others.values() if entry.clock is None)
    return Rows(t=np.arange(len(motion.of(first.values))) / float(numbers[0]), unit="s")


def since(clock: NDArray[Any], zero: Any) -> NDArray[Any]:
    """Clock readings after `zero`; whole numbers stay whole, as nanoseconds since 1970 do not fit a float64."""
    if clock.dtype.kind == "f" or isinstance(zero, float):
        return clock - zero
    return clock.astype(np.int64) - np.int64(zero)


def resample(samples: Array, clock: Array, t: Array, how: Resample) -> tuple[Array, BoolArray]:
    """Samples (C, P) taken at the times `clock` (C,) [s], at the rows `t` (T,) [s]; `how` as keys.toml says.

    Returns:
        Samples (T, P), NaN where there is none, and the rows between the first sample and the last (T,).
    """
    if clock.shape != samples.shape[:1]:
        raise FFGymError(f"its clock has {clock.size} times for {len(samples)} samples.")
    if len(clock) < 2 or len(t) < 2:
        raise FFGymError(f"has {len(clock)} samples for {len(t)} rows; to resample takes at least 2 of each.")
    stalled = np.flatnonzero(~(np.diff(clock) > 0))
    if stalled.size:
        row = int(stalled[0]) + 1
        raise FFGymError(f"its clock must increase, but sample {row} is at {clock[row]} s after {clock[row - 1]} s.")
    if how == "gaps":
        return _in_nearest_rows(samples, clock, t), np.ones(len(t), dtype=np.bool_)
    if how == "linear":
        columns = [np.interp(t, clock, column, left=np.nan, right=np.nan) for column in samples.T]
        return np.stack(columns, axis=1), (t >= clock[0]) & (t <= clock[-1])
    # the last sample is held no longer than the longest of the others: after that the source has fallen silent
    last = np.searchsorted(clock, t, side="right") - 1
    reached = (last >= 0) & (t <= clock[-1] + np.max(np.diff(clock)))
    return np.where(reached[:, None], samples[last], np.nan), reached


def _in_nearest_rows(samples: Array, clock: Array, t: Array) -> Array:
    """Each sample goes into the row nearest to it, if that is within half a period; of several the nearest stays."""
    after = np.clip(np.searchsorted(t, clock), 1, len(t) - 1)
    row = np.where(clock - t[after - 1] <= t[after] - clock, after - 1, after)
    distance = np.abs(clock - t[row])
    farthest_first = np.argsort(-distance, kind="stable")
    placed = farthest_first[distance[farthest_first] <= float(np.median(np.diff(t))) / 2]
    at_rows = np.full((len(t), samples.shape[1]), np.nan)
    at_rows[row[placed]] = samples[placed]  # the last of several, which is the nearest
    return at_rows
