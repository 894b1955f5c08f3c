"""Numbers of a file in SI units, on the side of the gearbox on which a recording keeps them."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.logs.column import Column, Conversion, conversion, si_of
from ffgym.logs.column_map import ColumnMap
from ffgym.logs.contents import Contents
from ffgym.logs.gather import Target, target_of
from ffgym.recordings import Header
from ffgym.robot import RobotDescription


def to_si(values: NDArray[Any], column: Column, units: tuple[str, ...] | None, contents: Contents) -> Array:
    """Return sign * (unit (scale * values + offset)) as float64, shape (T, P) like `values`.

    Counts in two's complement get their sign first.

    Args:
        values: numbers of the file.
        column: the entry that they come from.
        units: SI unit of each part; None takes that of the entry's unit.
        contents: where arrays for scale and offset are.

    Raises:
        FFGymError: if a unit does not fit, or a list does not have one number per part.
    """
    n_parts = values.shape[-1]
    given = _units(column, n_parts)
    wanted = units or tuple(si_of(unit, column.counts_per_turn) for unit in given)
    steps = [conversion(have, want, column.counts_per_turn) for have, want in zip(given, wanted, strict=True)]
    numbers = _with_sign(values, column.twos_complement)
    with np.errstate(over="ignore", invalid="ignore"):  # a recording names the row that is not finite
        for name, neutral in (("scale", 1.0), ("offset", 0.0)):
            constants = _constants(name, getattr(column, name), n_parts, contents)
            if np.any(constants != neutral):
                numbers = numbers * constants if name == "scale" else numbers + constants
        return _signed(_converted(numbers, steps), column, n_parts)


def _with_sign(values: NDArray[Any], bits: int | None) -> Array:
    """Numbers, the upper half of which is negative if they are counts of `bits` in two's complement."""
    numbers: Array = values.astype(np.float64)
    if bits is None:
        return numbers
    span = 2.0**bits
    wrong = (numbers < 0) | (numbers >= span) | (numbers != np.round(numbers))
    if np.any(wrong):
        raise FFGymError(
            f"twos_complement = {bits}: {numbers[wrong][0]:g} is no whole number from 0 to {span - 1:g}; leave it out "
            "where numbers have their sign."
        )
    return np.where(numbers >= span / 2, numbers - span, numbers)


def user_units(target: Target, column: Column) -> dict[str, str]:
    """Units of columns of the user's own, by column.

    Raises:
        FFGymError: if there is not one unit for all, or one for each.
    """
    kept = [si_of(unit, column.counts_per_turn) for unit in _units(column, len(target.columns))]
    return dict(zip(target.columns, kept, strict=True))


def to_kept_side(values: Array, target: Target, column: Column, header: Header) -> Array:
    """Numbers (T, P) on the side of the gearbox on which the recording keeps them.

    Raises:
        FFGymError: if couplings between the axes call for all joints, and these are not all.
    """
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
        factors: Array = values * np.diag(matrix)[joints]
        return factors
    if len(joints) < len(header.joints):
        raise FFGymError(f"{target.key}: the axes are coupled; give all joints in one entry to change the side.")
    turned: Array = values @ matrix.T
    return turned


def _units(column: Column, n_parts: int) -> tuple[str, ...]:
    """Unit of each part in the file."""
    given = (column.unit,) * n_parts if isinstance(column.unit, str) else column.unit
    if len(given) != n_parts:
        raise FFGymError(f"unit lists {len(given)} units, must be one, or {n_parts}.")
    return given


def _constants(name: str, given: float | tuple[float, ...] | str, n_parts: int, contents: Contents) -> Array:
    numbers = contents.numbers(given) if isinstance(given, str) else given
    constants = np.asarray(numbers, dtype=np.float64).reshape(-1)
    if constants.size not in (1, n_parts):
        what = f"array {given!r}" if isinstance(given, str) else "list"
        raise FFGymError(f"{name}: the {what} has {constants.size} numbers, must be one, or {n_parts}.")
    if not np.all(np.isfinite(constants)):
        raise FFGymError(f"{name} = {constants.tolist()} must be finite.")
    if name == "scale" and np.any(constants == 0.0):
        raise FFGymError(f"scale = {constants.tolist()} must not be zero: nothing of the numbers would be left.")
    return constants


def _converted(numbers: Array, steps: list[Conversion]) -> Array:
    factors, shifts = np.array([s.factor for s in steps]), np.array([s.shift for s in steps])
    numbers = numbers * factors
    return numbers + shifts if np.any(shifts) else numbers


def _signed(numbers: Array, column: Column, n_parts: int) -> Array:
    signs = np.atleast_1d(column.sign)
    if signs.size not in (1, n_parts):
        raise FFGymError(f"sign lists {signs.size} signs, must be one, or {n_parts}.")
    signed: Array = numbers * signs
    return signed


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
