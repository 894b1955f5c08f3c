"""Currents and shares of a rated torque as torques, by what the robot's description says of its drives."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import final

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.logs.column_map import Column, ColumnMap
from ffgym.logs.target import target_of
from ffgym.recordings import Header
from ffgym.robot import RobotDescription


@final
@dataclass(frozen=True, kw_only=True)
class DriveUnit:
    """A unit of what drives a motor."""

    entry: str
    """Entry of the description that makes it a torque."""
    field: str
    """Its place in `robot.drive`, motor side, shape (N,)."""
    factor: float
    """Of the unit: 1e-3 for mA beside A."""
    scale: str
    """Unit of the scale that a column map may give instead."""


DRIVE_UNITS: Mapping[str, DriveUnit] = MappingProxyType(
    {
        "A": DriveUnit(entry="drive.torque_per_current", field="torque_per_current", factor=1.0, scale="N m/A"),
        "mA": DriveUnit(entry="drive.torque_per_current", field="torque_per_current", factor=1e-3, scale="N m/mA"),
        "%": DriveUnit(entry="drive.rated_torque", field="rated_torque", factor=1e-2, scale="N m/%"),
    }
)
"""Units that become torques with a number of the robot."""


def with_drive_units(columns: ColumnMap, header: Header, robot: RobotDescription | None) -> tuple[ColumnMap, Header]:
    """The map with torque for each column of a drive's unit, and the header with the factors in `meta`.

    Args:
        columns: the map.
        header: of the recordings.
        robot: its description, None for a map that names joints without one.

    Raises:
        FFGymError: if the robot does not say what a unit is as a torque; the message begins with the entry of the map.
    """
    found: dict[str, Column] = {}
    used: dict[str, list[float]] = {}
    for key, column in columns.columns.items():
        unit = _drive_unit(key, column, header)
        if unit is None:
            found[key] = column
            continue
        numbers = _numbers(key, column, unit, robot)
        used[unit.entry] = numbers.tolist()
        found[key] = _as_torque(key, column, unit.factor * numbers, header)
    meta = {entry.replace(".", "_"): numbers for entry, numbers in used.items()}
    return replace(columns, columns=found), replace(header, meta={**header.meta, **meta})


def _drive_unit(key: str, column: Column, header: Header) -> DriveUnit | None:
    """Unit of a drive in an entry for torques; None where numbers are torques already, or no torques."""
    units = {column.unit} if isinstance(column.unit, str) else set(column.unit)
    if len(units) > 1 or not units <= set(DRIVE_UNITS) or key == "timestamp":
        return None
    family = target_of(key, column, header.joints).family
    return DRIVE_UNITS[units.pop()] if family is not None and family.decided_by == "torque_semantics" else None


def _as_torque(key: str, column: Column, factors: Array, header: Header) -> Column:
    """The entry with `factors` (N,) in its scale and offset, so that it gives motor torques [N m]."""
    if isinstance(column.scale, str) or isinstance(column.offset, str):
        raise FFGymError(
            f"[columns.{key!r}]: scale and offset of unit {column.unit!r} must be numbers, not the name of an array; "
            "give unit = 'N m' with a scale that holds the torque."
        )
    own = factors[list(target_of(key, column, header.joints).joints or ())]
    scale, offset = (_several(name, given, own) for name, given in (("scale", column.scale), ("offset", column.offset)))
    return replace(column, unit="N m", side="motor", scale=scale, offset=offset)


def _several(name: str, given: float | tuple[float, ...], factors: Array) -> tuple[float, ...]:
    """`given` times the factors, one for each joint."""
    if isinstance(given, tuple) and len(given) not in (1, len(factors)):
        raise FFGymError(f"{name}: the list has {len(given)} numbers, must be one, or {len(factors)}.")
    return tuple((np.asarray(given) * factors).tolist())


def _numbers(key: str, column: Column, unit: DriveUnit, robot: RobotDescription | None) -> Array:
    numbers = None if robot is None else getattr(robot.drive, unit.field)
    if numbers is None:
        named = "the map names joints without a description" if robot is None else f"{robot.name} has none"
        raise FFGymError(
            f"[columns.{key!r}]: unit {column.unit!r} becomes a torque by {unit.entry} of the robot's description, and "
            f'{named}. Add a table [{unit.entry}] to the description (with side = "link" if it counts behind the '
            f"gearbox), or give scale = <{unit.scale}> and unit = 'N m' in the column map."
        )
    if column.side:
        raise FFGymError(
            f"[columns.{key!r}]: side = {column.side!r} does not go with unit {column.unit!r}: the side is that of "
            f"{unit.entry} in the description. Leave it out."
        )
    return numbers
