"""From the arrays of a file to recordings, as a column map says."""

from dataclasses import replace

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import BoolArray
from ffgym.logs.clock_order import increasing, order_note
from ffgym.logs.clocks import Rows, rows_at_rate, rows_of
from ffgym.logs.column_map import ColumnMap
from ffgym.logs.contents import Contents
from ffgym.logs.entries import TIMESTAMP, Entries, Entry, entries_of, in_entry
from ffgym.logs.motions import Motion, motions_of
from ffgym.logs.resampling import DONE, Resampled, resample
from ffgym.logs.si import to_kept_side, to_si, user_units
from ffgym.recordings import Header, Recording


def recordings_of(contents: Contents, columns: ColumnMap, header: Header) -> list[Recording]:
    """Recordings of all motions in a file.

    Args:
        contents: the file.
        columns: what its arrays mean.
        header: of the recordings; its segment names a single motion, and begins the names of several.

    Raises:
        FFGymError: if an array is missing or does not fit, or the result is no valid recording; the message names the
            entry.
    """
    entries = entries_of(contents, columns, header)
    header = _completed(header, entries)
    motions = motions_of(contents, columns, header.segment, entries.arrays)
    return [_recording(contents, columns, entries, header, motion) for motion in motions]


def _completed(header: Header, entries: Entries) -> Header:
    """Header with the units of the user's columns, and what was done or left out on the way."""
    units: dict[str, str] = {}
    filters = list(header.filters)
    for key, entry in entries.others.items():
        if entry.target.family is None:
            with in_entry(key):
                units |= user_units(entry.target, entry.column)
        if entry.column.resample:
            filters.append(f"{key}: {DONE[entry.column.resample]}")
    left_out = {"left_out": entries.left_out} if entries.left_out else {}
    return replace(header, units=units, filters=tuple(filters), provenance={**header.provenance, **left_out})


def _recording(contents: Contents, columns: ColumnMap, entries: Entries, header: Header, motion: Motion) -> Recording:
    with in_entry(TIMESTAMP):
        every = _rows(contents, entries, motion)
    ordered = increasing(every.t)
    rows = every if ordered.all() else replace(every, t=every.t[ordered])
    table = {TIMESTAMP: rows.t}
    reached: BoolArray = np.ones(len(rows.t), dtype=np.bool_)
    for key, entry in entries.others.items():
        with in_entry(key):
            samples, within = _at_rows(contents, entry, header, motion, rows, ordered)
            _check_reach(entry, within, trim=columns.trim)
            kept = to_kept_side(samples, entry.target, entry.column, header)
        reached &= within
        table |= dict(zip(entry.target.columns, kept.T, strict=True))
    notes = {} if ordered.all() else {"conditioning": [order_note(every.t, ordered)]}
    header = replace(header, segment=motion.segment, meta={**header.meta, **motion.meta, **notes})
    if columns.trim:
        table = {name: values[reached] for name, values in table.items()}
    return Recording(table, header)


def _rows(contents: Contents, entries: Entries, motion: Motion) -> Rows:
    """Times of the rows of a motion."""
    if entries.times is not None:
        return rows_of(contents, entries.timestamp, motion.of(entries.times))
    rate = entries.timestamp.rate_hz
    first = next(entry for entry in entries.others.values() if entry.clock is None)
    return rows_at_rate(contents, rate or "", len(motion.of(first.values)))


def _at_rows(
    contents: Contents, entry: Entry, header: Header, motion: Motion, rows: Rows, ordered: BoolArray
) -> Resampled:
    """SI numbers of an entry on the side of the file, one sample per row of those in the file that are `ordered`."""
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
    return Resampled(samples[ordered], np.ones(len(rows.t), dtype=np.bool_))


def _check_reach(entry: Entry, reached: BoolArray, *, trim: bool) -> None:
    """Rows without a sample are dropped if the map says so, NaN where that may be, and an error elsewhere."""
    if trim or entry.target.may_miss or reached.all():
        return
    row = int(np.argmin(reached))
    raise FFGymError(
        f"has no sample for {np.sum(~reached)} of {len(reached)} rows, the first of them {row}. trim = true in [log] "
        "drops rows before and after the samples."
    )
