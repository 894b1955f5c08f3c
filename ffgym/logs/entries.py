"""Entries of a column map beside the arrays of a file that they name."""

import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import final

from ffgym.core.errors import FFGymError
from ffgym.logs.column import Column
from ffgym.logs.column_map import ColumnMap, builtin_columns, load_columns
from ffgym.logs.contents import Contents
from ffgym.logs.gather import PLACE, Gathered, Target, gather, source_names, target_of
from ffgym.recordings import Header

TIMESTAMP = "timestamp"

_ANY = {"joint": ".+", "number": r"\d+", "index": r"\d+"}
"""What may stand in a place of a name, as long as it is not known whose log it is."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Entry:
    """One entry of the map, and its arrays."""

    column: Column
    target: Target
    values: Gathered
    clock: Gathered | None
    """Times of the samples, one part; None where they are the times of the rows."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Entries:
    """All entries of a map that a file has arrays for."""

    timestamp: Column
    """How the times of the rows are known."""
    times: Gathered | None
    """Them, one part; None for a constant rate."""
    others: dict[str, Entry]
    """Everything else, by key."""
    left_out: list[str]
    """Optional entries that the file has nothing for."""

    @property
    def arrays(self) -> list[Gathered]:
        """All arrays, clocks included."""
        held = [self.times, *(array for entry in self.others.values() for array in (entry.values, entry.clock))]
        return [array for array in held if array is not None]


@contextmanager
def in_entry(key: str) -> Iterator[None]:
    """Begin what goes wrong with the name of the entry.

    Raises:
        FFGymError: in place of one within.
    """
    try:
        yield
    except FFGymError as error:
        raise FFGymError(f"[columns.{key!r}]: {error}") from error


def entries_of(contents: Contents, columns: ColumnMap, header: Header) -> Entries:
    """Find the arrays of all entries.

    Raises:
        FFGymError: if one is missing or has another shape than it must; the message names the entry.
    """
    timestamp = _clock_there_is(contents, columns.columns[TIMESTAMP])
    with in_entry(TIMESTAMP):
        times = _times(contents, timestamp)
    others: dict[str, Entry] = {}
    left_out: list[str] = []
    for key, column in columns.columns.items():
        if key == TIMESTAMP:
            continue
        with in_entry(key):
            target = target_of(key, column, header.joints)
            names = _names(contents, column, target, header.joints)
            if column.optional and not _present(contents, names):
                left_out.append(key)
                continue
            others[key] = _entry(contents, column, target, names, timestamp)
    if not any(entry.clock is None for entry in others.values()):
        raise FFGymError("No column has the clock of timestamp; at least one must.")
    return Entries(timestamp=timestamp, times=times, others=others, left_out=left_out)


def _times(contents: Contents, timestamp: Column) -> Gathered | None:
    if timestamp.resample or timestamp.optional or timestamp.side or timestamp.parts:
        raise FFGymError("the clock of the rows has no resample, optional, side or parts.")
    if timestamp.rate_hz is not None:
        if timestamp.from_first:
            raise FFGymError("rate_hz counts from 0 already; leave from_first out.")
        return None
    if not isinstance(timestamp.source, str) or not isinstance(timestamp.unit, str):
        raise FFGymError("the clock of the rows is one array in one unit.")
    return gather(contents, timestamp, timestamp.source, 1)


def _clock_there_is(contents: Contents, timestamp: Column) -> Column:
    """The clock of the rows by the first of its names that the file has."""
    here = (name for name in (timestamp.source, *timestamp.otherwise) if name in contents.arrays)
    return replace(timestamp, source=next(here, timestamp.source), otherwise=())


def _names(contents: Contents, column: Column, target: Target, joints: Sequence[str]) -> tuple[str, ...] | str:
    """Names of the arrays of an entry: those of its source, or the first of the others that the file has."""
    tried = [column, *(replace(column, source=name, otherwise=()) for name in column.otherwise)]
    found = [source_names(each, target, joints) for each in tried]
    return next((names for names in found if _present(contents, names)), found[0])


def _entry(
    contents: Contents, column: Column, target: Target, names: tuple[str, ...] | str, timestamp: Column
) -> Entry:
    if column.rate_hz is not None:
        raise FFGymError("rate_hz belongs to timestamp.")
    if column.from_first and target.key != "tcp.timestamp":
        raise FFGymError("from_first belongs to timestamp and tcp.timestamp.")
    if column.from_first and column.is_scaled:
        raise FFGymError("from_first takes the clock in its unit, without scale, offset or sign.")
    if column.resample and timestamp.is_scaled:
        raise FFGymError("resample compares clocks in their units; timestamp then has no scale, offset or sign.")
    values = gather(contents, column, names, len(target.columns))
    if column.times:
        values = _times_row(contents, column, values)
    return Entry(column=column, target=target, values=values, clock=_clock(contents, column, target, values, timestamp))


def _times_row(contents: Contents, column: Column, values: Gathered) -> Gathered:
    """Numbers times those of the array `times`, row by row."""
    axes = ("motion", "time") if contents.numbers(column.times).ndim == 2 else ("time",)
    factors = gather(contents, Column(source=column.times, unit="1", axes=axes), column.times, 1)
    if factors.values.shape[:2] != values.values.shape[:2]:
        raise FFGymError(
            f"times = {column.times!r} has {factors.values.shape[1]} rows, must be {values.values.shape[1]}, as source."
        )
    return replace(values, values=values.values * factors.values)


def _clock(contents: Contents, column: Column, target: Target, values: Gathered, timestamp: Column) -> Gathered | None:
    """Times of samples that are not those of the rows."""
    source = timestamp.source if isinstance(timestamp.source, str) else ""
    if not column.resample:
        if source and values.stream != contents.streams.get(source):
            raise FFGymError(
                f"its samples come with the clock of {values.stream!r}, and timestamp with another. Say what "
                "becomes of them between rows: resample = 'gaps', 'linear' or 'hold'."
            )
        return None
    if column.resample == "gaps" and not target.may_miss:
        raise FFGymError(f"resample = 'gaps' leaves NaN, which {target.key} may not hold; take 'linear' or 'hold'.")
    if column.resample == "linear" and target.family is not None and target.family.parts == "quaternion":
        raise FFGymError("resample = 'linear' between orientations gives none; take 'gaps' or 'hold'.")
    name = column.clock or _clock_of_stream(contents, values.stream, source)
    axes = ("motion", "time") if contents.numbers(name).ndim == 2 else ("time",)
    return gather(contents, Column(source=name, unit="s", axes=axes), name, 1)


def _clock_of_stream(contents: Contents, stream: str | None, timestamp: str) -> str:
    """The clock of a stream that is of the same kind as that of the rows."""
    kinds = [kind for clocks in contents.clocks.values() for kind, name in clocks.items() if name == timestamp]
    clocks = contents.clocks.get(stream, {}) if stream is not None else {}
    if not kinds or kinds[0] not in clocks:
        raise FFGymError("resample needs clock: the name of the array with the times of these samples.")
    return clocks[kinds[0]]


def _present(contents: Contents, names: tuple[str, ...] | str) -> bool:
    """Whether the file has the arrays of an entry."""
    wanted = {names} if isinstance(names, str) else set(names)
    return wanted <= set(contents.arrays)


def fitting_maps(contents: Contents) -> list[str]:
    """Names of built-in column maps all of whose entries that are not optional the file has arrays for."""
    return [name for name in builtin_columns() if _fits(load_columns(name), contents)]


def _fits(columns: ColumnMap, contents: Contents) -> bool:
    return all(column.optional or _held(column, contents) for column in columns.columns.values())


def _held(column: Column, contents: Contents) -> bool:
    """Whether the file has arrays for an entry, of one joint at least."""
    if isinstance(column.rate_hz, str):
        return column.rate_hz in contents.arrays
    if isinstance(column.source, tuple):
        return set(column.source) <= set(contents.arrays)
    return not column.source or any(_has(name, contents) for name in (column.source, *column.otherwise))


def _has(name: str, contents: Contents) -> bool:
    parts = [_ANY[part] if k % 3 == 1 else re.escape(part) for k, part in enumerate(PLACE.split(name)) if k % 3 != 2]
    pattern = re.compile("".join(parts))
    return any(pattern.fullmatch(array) for array in contents.arrays)
