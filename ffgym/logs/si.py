"""Columns of a recording that an entry of a column map fills: in SI units, on the side of the gearbox that is kept."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.logs.column import MappedColumn, conversion, si_of
from ffgym.logs.contents import Contents
from ffgym.recordings import FAMILIES, Family, Header
from ffgym.recordings.schema import USER_PREFIX, closest

_SLIDE_UNITS = {"rad": "m", "rad/s": "m/s", "rad/s^2": "m/s^2", "N m": "N"}
"""Units behind the gearbox of a sliding joint, by those of a hinge."""


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
        """Tell whether NaN may stand for a missing sample."""
        return self.family is not None and self.family.may_miss

    def kept_side(self, header: Header) -> str | None:
        """Side of the gearbox on which the recording keeps the numbers; None if it cannot be chosen."""
        if self.family is None or not self.family.decided_by:
            return None
        if self.family.decided_by == "position_side":
            return header.position_side
        return "link" if header.torque_semantics == "link_side" else "motor"

    def file_side(self, header: Header, column: MappedColumn) -> str | None:
        """Side of the numbers in the file."""
        kept = self.kept_side(header)
        if column.side and kept is None:
            raise FFGymError(f"side = {column.side!r} has no meaning for {self.key}; leave it out.")
        return column.side or kept

    def units(self, header: Header, column: MappedColumn) -> tuple[str, ...]:
        """SI unit of each column, on the side of the file; for columns of the user's own that of the entry's unit."""
        if self.family is None:
            return tuple(si_of(unit, column.counts_per_turn) for unit in each("unit", column.unit, len(self.columns)))
        if self.joints is None:
            return (self.family.unit,) * len(self.columns)
        behind = (self.file_side(header, column) or self.family.side) == "link"
        slides = [behind and header.joint_types[joint] == "slide" for joint in self.joints]
        return tuple(_SLIDE_UNITS.get(self.family.unit, self.family.unit) if s else self.family.unit for s in slides)


def target_of(key: str, column: MappedColumn, joints: Sequence[str]) -> Target:
    """Columns that the entry `key` fills on a robot with `joints`."""
    if key.startswith(USER_PREFIX):
        names = tuple(f"{key}.{part}" for part in column.parts) or (key,)
        return Target(key=key, family=None, columns=names, joints=None)
    if column.parts:
        raise FFGymError(f"parts belongs to user. columns; {key} has the joints of the robot or the axes of space.")
    for family in FAMILIES.values():
        names = family.columns(joints)
        if key == family.name or key in names:
            filled = names if key == family.name else (key,)
            numbers = tuple(map(names.index, filled)) if family.parts == "joint" else None
            return Target(key=key, family=family, columns=filled, joints=numbers)
    raise FFGymError(
        f"Unknown column {key!r}. {closest(key, FAMILIES)} On this robot they end in {', '.join(joints)}; columns of "
        "your own are called user.<name>."
    )


def each(name: str, given: Any, n_parts: int) -> tuple[Any, ...]:
    """Give each part its value: one for all, or a list."""
    if not isinstance(given, tuple):
        return (given,) * n_parts
    if len(given) not in (1, n_parts):
        raise FFGymError(f"{name}: the list has {len(given)} entries, must be one, or {n_parts}.")
    return given if len(given) == n_parts else given * n_parts


def to_si(values: NDArray[Any], column: MappedColumn, units: tuple[str, ...], contents: Contents) -> Array:
    """Return sign * (unit (scale * values + offset)) in `units`, float64, shape (T, P) like `values`.

    Counts in two's complement get their sign first.
    """
    n_parts = values.shape[-1]
    given = each("unit", column.unit, n_parts)
    steps = [conversion(have, want, column.counts_per_turn) for have, want in zip(given, units, strict=True)]
    numbers: Array = values.astype(np.float64)
    if column.twos_complement is not None:
        numbers = _with_sign(numbers, column.twos_complement)
    with np.errstate(over="ignore", invalid="ignore"):  # a recording names the row that is not finite
        scale, offset = (_constants(name, getattr(column, name), n_parts, contents) for name in ("scale", "offset"))
        if np.any(scale != 1.0):
            numbers = numbers * scale
        if np.any(offset != 0.0):
            numbers = numbers + offset
        numbers = numbers * np.array([step.factor for step in steps])
        if any(step.shift for step in steps):
            numbers = numbers + np.array([step.shift for step in steps])
        return numbers * np.array(each("sign", column.sign, n_parts))


def _with_sign(numbers: Array, bits: int) -> Array:
    """Counts of `bits` in two's complement, the upper half of which is negative."""
    span = 2.0**bits
    wrong = (numbers < 0) | (numbers >= span) | (numbers != np.round(numbers))
    if np.any(wrong):
        raise FFGymError(
            f"twos_complement = {bits}: {numbers[wrong][0]:g} is no whole number from 0 to {span - 1:g}; leave it out "
            "where numbers have their sign."
        )
    return np.where(numbers >= span / 2, numbers - span, numbers)


def _constants(name: str, given: float | tuple[float, ...] | str, n_parts: int, contents: Contents) -> Array:
    """Scale or offset, one number or one per part."""
    constants = np.asarray(contents.numbers(given) if isinstance(given, str) else given, dtype=np.float64).reshape(-1)
    if constants.size not in (1, n_parts):
        what = f"array {given!r}" if isinstance(given, str) else "list"
        raise FFGymError(f"{name}: the {what} has {constants.size} numbers, must be one, or {n_parts}.")
    if not np.all(np.isfinite(constants)):
        raise FFGymError(f"{name} = {constants.tolist()} must be finite.")
    if name == "scale" and np.any(constants == 0.0):
        raise FFGymError(f"scale = {constants.tolist()} must not be zero, which erases a column.")
    return constants


def to_kept_side(values: Array, target: Target, column: MappedColumn, header: Header) -> Array:
    """Numbers (T, P) on the side of the gearbox on which the recording keeps them."""
    kept, side = target.kept_side(header), target.file_side(header, column)
    if kept == side or target.joints is None or target.family is None:
        return values
    matrix = np.diag(header.gear_ratio) + (0.0 if header.coupling is None else np.array(header.coupling))
    if target.family.decided_by == "torque_semantics":  # torque in front = G^-T torque behind
        matrix = np.linalg.inv(matrix).T
    if kept == "link":
        matrix = np.linalg.inv(matrix)
    joints = list(target.joints)
    if header.coupling is None:
        return np.asarray(values * np.diag(matrix)[joints])
    if len(joints) < len(header.joints):
        raise FFGymError(f"{target.key}: the axes are coupled; give all joints in one entry to change the side.")
    return np.asarray(values @ matrix.T)
