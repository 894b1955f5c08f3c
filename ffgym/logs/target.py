"""Which columns of a recording an entry of a column map fills, and in which units its numbers must come."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

from ffgym.core.errors import FFGymError
from ffgym.logs.column_map import Column
from ffgym.recordings import FAMILIES, Family, Header
from ffgym.recordings.schema import USER_PREFIX, closest

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
