"""Tables of poses or joint positions in CSV files: columns with units, with or without times."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.paths.motions.parts.place import LARGEST, UNIT_NORM
from ffgym.paths.moves import FARTHEST
from ffgym.recordings.csv import read_table

UNITS: Mapping[str, tuple[str, float]] = {
    "s": ("s", 1.0),
    "ms": ("s", 1e-3),
    "m": ("m", 1.0),
    "mm": ("m", 1e-3),
    "rad": ("rad", 1.0),
    "deg": ("rad", np.pi / 180),
}
"""Units at the end of a column's name: what they measure in SI, and the factor to it."""

POSITION = ("x", "y", "z")
QUATERNION = ("qw", "qx", "qy", "qz")
RPY = ("roll", "pitch", "yaw")
JUMP = 5.0
"""Ratio of a time step to the median one from which it counts as a jump of the clock; chosen: rows may be missing here
and there, and log files thin out, but between rows so far apart nobody knows what the robot did."""
FEWEST_TIMES = 4
"""Fewest rows with times: a spline that is smooth needs as many."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Table:
    """Rows of a file, in SI units. Either positions or joints are there, never both."""

    name: str
    """Of the file, for messages."""
    t: Array | None
    """Times from 0 [s], increasing, shape (T,); None where the rows are points to go through."""
    positions: Array | None
    """TCP in the world [m], shape (T, 3)."""
    rotations: Array | None
    """Orientation of tool0 in the world, shape (T, 3, 3); None where none is given."""
    joints: Array | None
    """Joint positions, link side [rad or m], shape (T, N)."""


def parse_table(text: str, where: str, joints: Sequence[str], units: Sequence[str]) -> Table:
    """Table from CSV text; lines that begin with # are comments.

    Args:
        text: the whole file.
        where: names it in messages.
        joints: names of the robot's joints.
        units: of their positions, 'rad' or 'm'.

    Raises:
        FFGymError: if columns are missing, unknown or in a wrong unit, or a value makes no sense.
    """
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    lines = ["" if line.lstrip().startswith("#") else line for line in lines]
    try:
        names, values = read_table(lines, 0)
        columns = _in_si(names, values, {**dict.fromkeys(POSITION, "m"), **dict(zip(joints, units, strict=True))})
        return _table(where, columns, joints)
    except FFGymError as error:
        raise FFGymError(f"{where}: {error}") from error


def _in_si(names: Sequence[str], values: Array, wanted: Mapping[str, str]) -> dict[str, Array]:
    """Columns without the units in their names, in SI units.

    Args:
        names: of the columns, with units.
        values: shape (T, columns).
        wanted: what each known column measures, 'm' or 'rad', beside time and orientation.
    """
    known = {"t": "s", **dict.fromkeys(QUATERNION, ""), **dict.fromkeys(RPY, "rad"), **wanted}
    columns: dict[str, Array] = {}
    for i, full in enumerate(names):
        name, factor = _without_unit(full, known)
        if name in columns:
            raise FFGymError(f"Column {full!r} says {name!r} a second time.")
        if not np.all(np.isfinite(values[:, i])):
            row = int(np.flatnonzero(~np.isfinite(values[:, i]))[0])
            raise FFGymError(f"Row {row + 1}, column {full!r} is {values[row, i]}, must be a finite number.")
        columns[name] = values[:, i] * factor
        if name != "t":  # clocks may count from long ago
            _check_unit(full, columns[name], FARTHEST if name in POSITION else LARGEST)
    return columns


def _check_unit(full: str, column: Array, largest: float) -> None:
    """Refuse values that are surely in another unit than the column's name says."""
    beyond = np.flatnonzero(np.abs(column) > largest)
    if beyond.size:
        row = int(beyond[0])
        raise FFGymError(
            f"Row {row + 1}, column {full!r} is {column[row]:.6g} in SI units, which is beyond {largest:g}; is it in "
            f"another unit?"
        )


def _without_unit(full: str, known: Mapping[str, str]) -> tuple[str, float]:
    """Name of a column and the factor of its unit."""
    if known.get(full) == "":
        return full, 1.0
    name, _, unit = full.rpartition("_")
    if name not in known or known[name] == "":
        some = ", ".join(_with_units(name, kind) for name, kind in known.items())
        raise FFGymError(f"Unknown column {full!r}. A table may have {some}.")
    if UNITS.get(unit, ("", 0.0))[0] != known[name]:
        raise FFGymError(f"Column {full!r} must be {_with_units(name, known[name])}.")
    return name, UNITS[unit][1]


def _with_units(name: str, kind: str) -> str:
    return " or ".join(f"{name}_{unit}" for unit, (measured, _) in UNITS.items() if measured == kind) or name


def _table(where: str, columns: Mapping[str, Array], joints: Sequence[str]) -> Table:
    of_tool = [name for name in (*POSITION, *QUATERNION, *RPY) if name in columns]
    of_joints = [name for name in joints if name in columns]
    if of_tool and of_joints:
        raise FFGymError(f"Columns {of_tool[0]!r} and {of_joints[0]!r}: give poses or joint positions, not both.")
    if not of_tool and not of_joints:
        raise FFGymError(f"There are neither x, y, z nor joint positions ({', '.join(joints)}) with their units.")
    n_rows = len(next(iter(columns.values())))
    t = _times(columns["t"]) if "t" in columns else None
    if n_rows < (1 if t is None else FEWEST_TIMES):
        raise FFGymError(f"There are {n_rows} rows, must be at least {1 if t is None else FEWEST_TIMES}.")
    return Table(
        name=where,
        t=t,
        positions=_together(columns, POSITION) if of_tool else None,
        rotations=_rotations(columns) if of_tool else None,
        joints=_together(columns, joints) if of_joints else None,
    )


def _together(columns: Mapping[str, Array], names: Sequence[str]) -> Array:
    """Columns that belong together, shape (T, K)."""
    missing = [name for name in names if name not in columns]
    if missing:
        raise FFGymError(f"Columns {', '.join(names)} belong together; {', '.join(missing)} is missing.")
    return np.stack([columns[name] for name in names], axis=1)


def _rotations(columns: Mapping[str, Array]) -> Array | None:
    has_quaternion, has_rpy = (any(name in columns for name in names) for names in (QUATERNION, RPY))
    if has_quaternion and has_rpy:
        raise FFGymError("Quaternion and roll, pitch, yaw say the same; give one of them.")
    if has_rpy:
        return Rotation.from_euler("xyz", _together(columns, RPY)).as_matrix()
    if not has_quaternion:
        return None
    values = _together(columns, QUATERNION)
    norm = np.linalg.norm(values, axis=1)
    if np.abs(norm - 1).max() > UNIT_NORM:
        row = int(np.argmax(np.abs(norm - 1)))
        raise FFGymError(f"Row {row + 1}: the quaternion qw, qx, qy, qz must have norm 1, not {norm[row]:.6g}.")
    return Rotation.from_quat(values, scalar_first=True).as_matrix()


def _times(t: Array) -> Array:
    """Times from 0, checked."""
    steps = np.diff(t)
    if np.any(steps <= 0):
        row = int(np.flatnonzero(steps <= 0)[0])
        raise FFGymError(
            f"Row {row + 2}, column 't': {t[row + 1]:.9g} s is not after {t[row]:.9g} s in the row before; times must "
            f"increase."
        )
    if len(steps) and steps.max() > JUMP * np.median(steps):
        row = int(np.argmax(steps))
        raise FFGymError(
            f"Row {row + 2}, column 't': the clock jumps by {steps[row]:.6g} s, where rows are "
            f"{np.median(steps):.6g} s apart. Cut the table there, or fill the gap."
        )
    return t - t[0] if len(t) else t
