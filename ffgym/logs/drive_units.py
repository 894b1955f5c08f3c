"""Units of what drives a motor - currents, shares of a rated torque -, which a number of the robot makes torques."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ffgym.core.errors import FFGymError, errors_at
from ffgym.core.types import Array
from ffgym.logs.column import MappedColumn
from ffgym.logs.column_map import ColumnMap
from ffgym.logs.entries import TIMESTAMP, place_of
from ffgym.logs.si import each, target_of
from ffgym.recordings import Header
from ffgym.robot import RobotDescription

DRIVE_UNITS: Mapping[str, tuple[str, float]] = {
    "A": ("torque_per_current", 1.0),
    "mA": ("torque_per_current", 1e-3),
    "%": ("rated_torque", 1e-2),
}
"""Unit -> entry of the robot's drive, motor side, that makes it a torque; and the size of the unit in that entry's."""


def with_drive_units(columns: ColumnMap, header: Header, robot: RobotDescription | None) -> tuple[ColumnMap, Header]:
    """The map with torque for each column of a drive's unit, and the header with the factors in `meta`.

    `robot` is None for a map that names joints without a description.
    """
    found = dict(columns.columns)
    meta = dict(header.meta)
    for key, column in columns.columns.items():
        units = {column.unit} if isinstance(column.unit, str) else set(column.unit)
        if key == TIMESTAMP or len(units) > 1 or not units <= set(DRIVE_UNITS):
            continue
        target = target_of(key, column, header.joints)
        if target.family is None or target.family.decided_by != "torque_semantics":
            continue
        entry, size = DRIVE_UNITS[units.pop()]
        with errors_at(place_of(key)):
            numbers = _numbers(column, entry, robot)
            found[key] = _as_torque(column, (size * numbers)[list(target.joints or ())])
        meta[f"drive_{entry}"] = numbers.tolist()
    return replace(columns, columns=found), replace(header, meta=meta)


def _numbers(column: MappedColumn, entry: str, robot: RobotDescription | None) -> Array:
    """Torque per unit of each joint, (N,)."""
    numbers: Array | None = None if robot is None else getattr(robot.drive, entry)
    if numbers is None:
        named = "the map names joints without a description" if robot is None else f"{robot.name} has none"
        raise FFGymError(
            f"unit {column.unit!r} becomes a torque by drive.{entry} of the robot's description, and {named}. Add a "
            f'table [drive.{entry}] to the description (with side = "link" if it counts behind the gearbox), or give '
            f"scale = <N m/{column.unit}> and unit = 'N m' in the column map."
        )
    if column.side:
        raise FFGymError(
            f"side = {column.side!r} does not go with unit {column.unit!r}: the side is that of drive.{entry} in the "
            "description. Leave it out."
        )
    return numbers


def _as_torque(column: MappedColumn, factors: Array) -> MappedColumn:
    """The entry with `factors` (P,) in its scale and offset, so that it gives motor torques [N m]."""
    if isinstance(column.scale, str) or isinstance(column.offset, str):
        raise FFGymError(
            f"scale and offset of unit {column.unit!r} must be numbers, not the name of an array; give unit = 'N m' "
            "with a scale that holds the torque."
        )
    scale, offset = (
        tuple((np.array(each(name, given, len(factors))) * factors).tolist())
        for name, given in (("scale", column.scale), ("offset", column.offset))
    )
    return replace(column, unit="N m", side="motor", scale=scale, offset=offset)
