"""The arrays that an entry of a column map names, as one array (motions, rows, parts)."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from ffgym.core.errors import FFGymError
from ffgym.logs.column import AXES, Column
from ffgym.logs.contents import Contents
from ffgym.recordings import FAMILIES, Family, Header
from ffgym.recordings.schema import USER_PREFIX, closest

PLACE = re.compile(r"\{(joint|number|index)((?<!joint)[+-]\d+)?\}")
"""Where the name of an array differs from joint to joint."""

_SLIDE_UNITS = {"rad": "m", "rad/s": "m/s", "rad/s^2": "m/s^2", "N m": "N"}
"""Units behind the gearbox of a sliding joint, by those of a hinge."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Target:
    """Columns of a recording that one entry fills."""

    key: str
    """Name of the entry."""
    family: Family | None
    """None for columns of the user's own."""
    columns: tuple[str, ...]
    """Their names, shape (P,)."""
    joints: tuple[int, ...] | None
    """Number of the joint of each column, from 0; None if they belong to none."""

    @property
    def may_miss(self) -> bool:
        """Whether NaN may stand for a missing sample."""
        return self.family is not None and self.family.may_miss

    def kept_side(self, header: Header) -> str | None:
        """Side of the gearbox on which the recording keeps the numbers; None if it cannot be chosen."""
        if self.family is None or not self.family.decided_by:
            return None
        if self.family.decided_by == "position_side":
            return header.position_side
        return "link" if header.torque_semantics == "link_side" else "motor"

    def file_side(self, header: Header, column: Column) -> str | None:
        """Side of the numbers in the file.

        Raises:
            FFGymError: if the entry says one, but this quantity has no side to choose.
        """
        kept = self.kept_side(header)
        if column.side and kept is None:
            raise FFGymError(f"side = {column.side!r} has no meaning for {self.key}; leave it out.")
        return column.side or kept

    def units(self, header: Header, column: Column) -> tuple[str, ...] | None:
        """SI unit of each part on the side of the file; None for columns of the user's own."""
        if self.family is None:
            return None
        if self.joints is None:
            return (self.family.unit,) * len(self.columns)
        side = self.file_side(header, column) or self.family.side
        types = [header.joint_types[joint] for joint in self.joints]
        behind = [kind == "slide" and side == "link" for kind in types]
        return tuple(_SLIDE_UNITS.get(self.family.unit, self.family.unit) if b else self.family.unit for b in behind)


def target_of(key: str, column: Column, joints: Sequence[str]) -> Target:
    """Columns that the entry `key` fills on a robot with `joints`.

    Raises:
        FFGymError: if the schema has no such family or column.
    """
    if key.startswith(USER_PREFIX):
        names = tuple(f"{key}.{part}" for part in column.parts) or (key,)
        return Target(key=key, family=None, columns=names, joints=None)
    if column.parts:
        raise FFGymError(f"parts belongs to user. columns; {key} has the joints of the robot or the axes of space.")
    if key in FAMILIES:
        family = FAMILIES[key]
        names = family.columns(joints)
        numbers = tuple(range(len(names))) if family.parts == "joint" else None
        return Target(key=key, family=family, columns=names, joints=numbers)
    for family in FAMILIES.values():
        if key in family.columns(joints):
            number = (family.columns(joints).index(key),) if family.parts == "joint" else None
            return Target(key=key, family=family, columns=(key,), joints=number)
    raise FFGymError(
        f"Unknown column {key!r}. {closest(key, FAMILIES)} On this robot they end in {', '.join(joints)}; columns of "
        "your own are called user.<name>."
    )


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Gathered:
    """Numbers as they are in the file, in one shape."""

    values: NDArray[Any]
    """Shape (M, T, P): motions, rows, parts; the file's own number type, so that no digit of a clock is lost."""
    stacked: bool
    """Whether the array had an axis of motions."""
    stream: str | None
    """Stream of the file that they belong to, None if it has no streams."""


def source_names(column: Column, target: Target, joints: Sequence[str]) -> tuple[str, ...] | str:
    """One name, or one for each part where the entry lists them or has a place for the joint."""
    source = column.source
    if isinstance(source, tuple) or not PLACE.search(source):
        return source
    numbers = range(len(target.columns)) if target.joints is None else target.joints
    if "{joint}" in source and target.joints is None:
        raise FFGymError(f"source = {source!r} has a place for a joint, but {target.key} has none; list the names.")

    def name(number: int) -> str:
        return PLACE.sub(lambda found: _filled(found, number, joints), source)

    return tuple(map(name, numbers))


def _filled(place: re.Match[str], number: int, joints: Sequence[str]) -> str:
    """What stands in a place of a name for the part `number`, from 0."""
    kind, step = place.groups()
    if kind == "joint":
        return joints[number]
    return str(number + (kind == "number") + int(step or 0))


def gather(contents: Contents, column: Column, names: tuple[str, ...] | str, n_parts: int) -> Gathered:
    """Numbers of the arrays `names` for the `n_parts` columns of an entry.

    Raises:
        FFGymError: if an array is missing, is not numbers, or does not have the shape that it must.
    """
    if isinstance(names, str):
        values = _picked(names, _in_order(names, contents.numbers(names), _axes(column, contents, names)), column)
        if values.shape[2] != n_parts:
            raise FFGymError(_wrong_parts(names, contents[names].shape, values.shape[2], n_parts))
    else:
        values = _side_by_side(contents, column, names, n_parts)
    first = names if isinstance(names, str) else names[0]
    stacked = column.axes is not None and "motion" in column.axes
    return Gathered(values=values, stacked=stacked, stream=contents.streams.get(first))


def _side_by_side(contents: Contents, column: Column, names: tuple[str, ...], n_parts: int) -> NDArray[Any]:
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


def _axes(column: Column, contents: Contents, name: str) -> tuple[str, ...]:
    if column.axes is not None:
        return column.axes
    array = contents.numbers(name)
    if array.ndim not in (1, 2):
        raise FFGymError(
            f'{name!r} has shape {array.shape}; say which axis is what, e.g. axes = ["motion", "time", "part"].'
        )
    return ("time",) if array.ndim == 1 else ("time", "part")


def _in_order(name: str, array: NDArray[Any], axes: tuple[str, ...]) -> NDArray[Any]:
    """The array with its axes in the order motion, time, part; axes that it lacks have length 1."""
    if array.ndim != len(axes):
        raise FFGymError(f"{name!r} has shape {array.shape}, but axes = {list(axes)} needs {len(axes)} of them.")
    present = [axis for axis in AXES if axis in axes]
    ordered = array.transpose([axes.index(axis) for axis in present])
    shape = [ordered.shape[present.index(axis)] if axis in present else 1 for axis in AXES]
    return ordered.reshape(shape)


def _picked(name: str, values: NDArray[Any], column: Column) -> NDArray[Any]:
    if column.pick is None:
        return values
    if max(column.pick) >= values.shape[2]:
        raise FFGymError(f"pick = {list(column.pick)}, but {name!r} has only {values.shape[2]} parts, counted from 0.")
    return values[:, :, list(column.pick)]


def _wrong_parts(name: str, shape: tuple[int, ...], n_found: int, n_parts: int) -> str:
    return (
        f"{name!r} has shape {shape} and so {n_found} parts, must be {n_parts}, one for each joint or axis of the "
        f'column. axes says which axis is what, e.g. ["part", "time"]; pick chooses parts; a map for another robot '
        f"does not fit."
    )
