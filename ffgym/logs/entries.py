"""Entries of a column map beside the arrays of a file that they name, each as one array (motions, rows, parts)."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ffgym.core.errors import FFGymError, errors_at
from ffgym.logs.column import AXES, MappedColumn
from ffgym.logs.column_map import ColumnMap, builtin_columns, load_columns
from ffgym.logs.contents import Contents
from ffgym.logs.si import Target, target_of
from ffgym.recordings import Header

TIMESTAMP = "timestamp"

_PLACE = re.compile(r"\{(joint|number|index)((?<!joint)[+-]\d+)?\}")
"""Part of an array's name that differs from joint to joint."""

_ANY = {"joint": ".+", "number": r"\d+", "index": r"\d+"}
"""Texts that may stand in a place of a name, as long as the robot of the log is not known."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Gathered:
    """Numbers as they are in the file, in one shape."""

    values: NDArray[Any]
    """Shape (M, T, P): motions, rows, parts; the file's own number type, so that no digit of a clock is lost."""
    stacked: bool
    """True if the array had an axis of motions."""
    stream: str | None
    """Stream of the file that they belong to, None if it has no streams."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Entry:
    """One entry of the map, and its arrays."""

    column: MappedColumn
    target: Target
    values: Gathered
    clock: Gathered | None
    """Times of the samples, one part; None where they are the times of the rows."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Entries:
    """All entries of a map that a file has arrays for."""

    timestamp: MappedColumn
    """Column of the times of the rows."""
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


def place_of(key: str) -> str:
    """Name of an entry at the beginning of a message."""
    return f"[columns.{key!r}]"


def entries_of(contents: Contents, columns: ColumnMap, header: Header) -> Entries:
    """Find the arrays of all entries."""
    # the clock of the rows, by the first of its names that the file has
    timestamp = columns.columns[TIMESTAMP]
    here = (name for name in (timestamp.source, *timestamp.otherwise) if name in contents.arrays)
    timestamp = replace(timestamp, source=next(here, timestamp.source), otherwise=())
    with errors_at(place_of(TIMESTAMP)):
        times = _times(contents, timestamp)
    others: dict[str, Entry] = {}
    left_out: list[str] = []
    for key, column in columns.columns.items():
        if key == TIMESTAMP:
            continue
        with errors_at(place_of(key)):
            target = target_of(key, column, header.joints)
            # of the sources that the entry names, the first that the file has
            tried = [column, *(replace(column, source=name, otherwise=()) for name in column.otherwise)]
            found = [_source_names(each, target, header.joints) for each in tried]
            names = next((names for names in found if _is_there(names, contents)), found[0])
            if column.optional and not _is_there(names, contents):
                left_out.append(key)
                continue
            others[key] = _entry(contents, column, target, names, timestamp)
    if not any(entry.clock is None for entry in others.values()):
        raise FFGymError("No column has the clock of timestamp; at least one must.")
    return Entries(timestamp=timestamp, times=times, others=others, left_out=left_out)


def _times(contents: Contents, timestamp: MappedColumn) -> Gathered | None:
    """Times of the rows; None for a constant rate."""
    if timestamp.resample or timestamp.optional or timestamp.side or timestamp.parts:
        raise FFGymError("the clock of the rows has no resample, optional, side or parts.")
    if timestamp.rate_hz is not None:
        if timestamp.from_first:
            raise FFGymError("rate_hz counts from 0 already; leave from_first out.")
        return None
    if not isinstance(timestamp.source, str) or not isinstance(timestamp.unit, str):
        raise FFGymError("the clock of the rows is one array in one unit.")
    return _gather(contents, timestamp, timestamp.source, 1)


def _source_names(column: MappedColumn, target: Target, joints: Sequence[str]) -> tuple[str, ...] | str:
    """One name, or one for each part where the entry lists them or has a place for the joint."""
    source = column.source
    if isinstance(source, tuple) or not _PLACE.search(source):
        return source
    if "{joint}" in source and target.joints is None:
        raise FFGymError(f"source = {source!r} has a place for a joint, but {target.key} has none; list the names.")

    def fill(number: int, place: re.Match[str]) -> str:
        kind, step = place.groups()
        return joints[number] if kind == "joint" else str(number + (kind == "number") + int(step or 0))

    numbers = range(len(target.columns)) if target.joints is None else target.joints
    return tuple(_PLACE.sub(partial(fill, number), source) for number in numbers)


def _is_there(names: tuple[str, ...] | str, contents: Contents) -> bool:
    """Tell whether the file has the arrays of an entry."""
    return ({names} if isinstance(names, str) else set(names)) <= set(contents.arrays)


def _entry(
    contents: Contents, column: MappedColumn, target: Target, names: tuple[str, ...] | str, timestamp: MappedColumn
) -> Entry:
    """An entry with the arrays `names`, and the clock that it has of its own."""
    if column.rate_hz is not None:
        raise FFGymError("rate_hz belongs to timestamp.")
    if column.from_first and target.key != "tcp.timestamp":
        raise FFGymError("from_first belongs to timestamp and tcp.timestamp.")
    if column.from_first and column.is_scaled:
        raise FFGymError("from_first takes the clock in its unit, without scale, offset or sign.")
    if column.resample and timestamp.is_scaled:
        raise FFGymError("resample compares clocks in their units; timestamp then has no scale, offset or sign.")
    values = _gather(contents, column, names, len(target.columns))
    if column.times:
        factors = _one_per_row(contents, column.times)
        if factors.values.shape[:2] != values.values.shape[:2]:
            raise FFGymError(
                f"times = {column.times!r} has {factors.values.shape[1]} rows, must be {values.values.shape[1]}, as "
                "source."
            )
        values = replace(values, values=values.values * factors.values)
    return Entry(column=column, target=target, values=values, clock=_clock(contents, column, target, values, timestamp))


def _clock(
    contents: Contents, column: MappedColumn, target: Target, values: Gathered, timestamp: MappedColumn
) -> Gathered | None:
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
    name = column.clock
    if not name:  # the clock of the stream that is of the same kind as that of the rows
        kinds = [kind for clocks in contents.clocks.values() for kind, clock in clocks.items() if clock == source]
        name = contents.clocks.get(values.stream or "", {}).get(kinds[0], "") if kinds else ""
    if not name:
        raise FFGymError("resample needs clock: the name of the array with the times of these samples.")
    return _one_per_row(contents, name)


def _one_per_row(contents: Contents, name: str) -> Gathered:
    """Array of one number per row, in one motion or several."""
    axes = ("motion", "time") if contents.numbers(name).ndim == 2 else ("time",)
    return _gather(contents, MappedColumn(source=name, unit="1", axes=axes), name, 1)


def _gather(contents: Contents, column: MappedColumn, names: tuple[str, ...] | str, n_parts: int) -> Gathered:
    """Numbers of the arrays `names` for the `n_parts` columns of an entry."""
    if isinstance(names, str):
        first, values = names, _all_parts(contents, column, names, n_parts)
    else:
        first, values = names[0], _side_by_side(contents, column, names, n_parts)
    stacked = column.axes is not None and "motion" in column.axes
    return Gathered(values=values, stacked=stacked, stream=contents.streams.get(first))


def _all_parts(contents: Contents, column: MappedColumn, name: str, n_parts: int) -> NDArray[Any]:
    """One array with all parts, or those that the entry picks."""
    array, axes = contents.numbers(name), column.axes
    if axes is None:
        if array.ndim not in (1, 2):
            raise FFGymError(
                f'{name!r} has shape {array.shape}; say which axis is what, e.g. axes = ["motion", "time", "part"].'
            )
        axes = ("time", "part")[: array.ndim]
    values = _in_order(name, array, axes)
    if column.pick is not None:
        if max(column.pick) >= values.shape[2]:
            raise FFGymError(
                f"pick = {list(column.pick)}, but {name!r} has only {values.shape[2]} parts, counted from 0."
            )
        values = values[:, :, list(column.pick)]
    if values.shape[2] != n_parts:
        raise FFGymError(
            f"{name!r} has shape {array.shape} and so {values.shape[2]} parts, must be {n_parts}, one for each joint "
            'or axis of the column. axes says which axis is what, e.g. ["part", "time"]; pick chooses parts; a map for '
            "another robot does not fit."
        )
    return values


def _side_by_side(contents: Contents, column: MappedColumn, names: tuple[str, ...], n_parts: int) -> NDArray[Any]:
    """One array for each part."""
    if len(names) != n_parts:
        raise FFGymError(f"source lists {len(names)} arrays, must be {n_parts}, one for each column.")
    if column.pick is not None or (column.axes is not None and "part" in column.axes):
        raise FFGymError("source lists one array for each part; pick and the axis 'part' belong to a single array.")
    arrays = [_in_order(name, contents.numbers(name), column.axes or ("time",)) for name in names]
    for name, array in zip(names, arrays, strict=True):
        if array.shape != arrays[0].shape:
            raise FFGymError(f"{name!r} has {array.shape[1]} rows, but {names[0]!r} has {arrays[0].shape[1]}.")
        if contents.streams.get(name) != contents.streams.get(names[0]):
            raise FFGymError(f"{name!r} and {names[0]!r} have different clocks; map them as columns of their own.")
    return np.concatenate(arrays, axis=2)


def _in_order(name: str, array: NDArray[Any], axes: tuple[str, ...]) -> NDArray[Any]:
    """The array with its axes in the order motion, time, part; axes that it lacks have length 1."""
    if array.ndim != len(axes):
        raise FFGymError(f"{name!r} has shape {array.shape}, but axes = {list(axes)} needs {len(axes)} of them.")
    present = [axis for axis in AXES if axis in axes]
    ordered = array.transpose([axes.index(axis) for axis in present])
    return ordered.reshape([ordered.shape[present.index(axis)] if axis in present else 1 for axis in AXES])


def fitting_maps(contents: Contents) -> list[str]:
    """Names of built-in column maps all of whose entries that are not optional the file has arrays for."""
    maps = {name: load_columns(name).columns.values() for name in builtin_columns()}
    return [name for name, columns in maps.items() if all(c.optional or _may_be_there(c, contents) for c in columns)]


def _may_be_there(column: MappedColumn, contents: Contents) -> bool:
    """Tell whether the file has arrays for an entry, of one joint at least."""
    if isinstance(column.rate_hz, str):
        return column.rate_hz in contents.arrays
    if isinstance(column.source, tuple):
        return set(column.source) <= set(contents.arrays)
    for name in (column.source, *column.otherwise):
        parts = _PLACE.split(name)  # text, kind of a place, step, text, ...
        pattern = "".join(_ANY[part] if k % 3 == 1 else re.escape(part) for k, part in enumerate(parts) if k % 3 != 2)
        if any(re.fullmatch(pattern, array) for array in contents.arrays):
            return True
    return not column.source
