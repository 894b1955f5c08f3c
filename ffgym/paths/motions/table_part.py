"""Tables of poses or joint positions in CSV files as moves: columns with units, with or without times."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, final

import numpy as np
import scipy

from ffgym.core.errors import FFGymError, check_number, errors_at
from ffgym.core.files import read_text
from ffgym.core.types import Array
from ffgym.paths.motion import CartesianPath, JointPath, Segment, sample
from ffgym.paths.motions.part import LARGEST, UNIT_NORM, MotionPart, PartContext, entry
from ffgym.paths.moves import FARTHEST, Move, MoveJointSpline, MoveSpline, MoveTimed, Pose, Speed
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
and there, and log files thin out, but between rows so far apart the motion is unknown."""
FEWEST_TIMES = 4
"""Fewest rows with times: a spline that is smooth needs as many."""


@dataclass(frozen=True, kw_only=True, eq=False)
class MotionTable:
    """Rows of a file, in SI units. Either positions or joints are there, never both."""

    t: Array | None
    """Times from 0 [s], increasing, shape (T,); None where the rows are points to go through."""
    positions: Array | None
    """TCP in the world [m], shape (T, 3)."""
    rotations: Array | None
    """Orientation of tool0 in the world, shape (T, 3, 3); None where none is given."""
    joints: Array | None
    """Joint positions, link side [rad or m], shape (T, N)."""


def parse_table(text: str, where: str, joints: Sequence[str], units: Sequence[str]) -> MotionTable:
    """Parse a table from CSV text, which errors call `where`; lines that begin with # are comments.

    `units` are those of the positions of the robot's `joints`, 'rad' or 'm'.
    """
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    lines = ["" if line.lstrip().startswith("#") else line for line in lines]
    with errors_at(where):
        names, values = read_table(lines, 0)
        columns = _in_si(names, values, {**dict.fromkeys(POSITION, "m"), **dict(zip(joints, units, strict=True))})
        return _table(columns, joints)


def _in_si(names: Sequence[str], values: Array, wanted: Mapping[str, str]) -> dict[str, Array]:
    """Columns of values (T, columns) without the units in their names, in SI units.

    `wanted` says what each known column measures, 'm' or 'rad', beside time and orientation.
    """
    known = {"t": "s", **dict.fromkeys(QUATERNION, ""), **dict.fromkeys(RPY, "rad"), **wanted}
    choices = {
        name: [f"{name}_{unit}" for unit, (measured, _) in UNITS.items() if measured == kind] or [name]
        for name, kind in known.items()
    }
    name_of = {full: name for name, fulls in choices.items() for full in fulls}
    columns: dict[str, Array] = {}
    for i, full in enumerate(names):
        if full not in name_of:
            near = full.rpartition("_")[0]
            if known.get(near):
                raise FFGymError(f"Column {full!r} must be {' or '.join(choices[near])}.")
            every = ", ".join(" or ".join(fulls) for fulls in choices.values())
            raise FFGymError(f"Unknown column {full!r}. A table may have {every}.")
        name = name_of[full]
        factor = UNITS[full.rpartition("_")[2]][1] if known[name] else 1.0
        if name in columns:
            raise FFGymError(f"Column {full!r} says {name!r} a second time.")
        if not np.all(np.isfinite(values[:, i])):
            row = int(np.flatnonzero(~np.isfinite(values[:, i]))[0])
            raise FFGymError(f"Row {row + 1}, column {full!r} is {values[row, i]}, must be a finite number.")
        columns[name] = column = values[:, i] * factor
        # refuse values that are surely in another unit than the name says; clocks may count from long ago
        largest = np.inf if name == "t" else FARTHEST if name in POSITION else LARGEST
        beyond = np.flatnonzero(np.abs(column) > largest)
        if beyond.size:
            row = int(beyond[0])
            raise FFGymError(
                f"Row {row + 1}, column {full!r} is {column[row]:.6g} in SI units, which is beyond {largest:g}; is it "
                f"in another unit?"
            )
    return columns


def _table(columns: Mapping[str, Array], joints: Sequence[str]) -> MotionTable:
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
    return MotionTable(
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
        return scipy.spatial.transform.Rotation.from_euler("xyz", _together(columns, RPY)).as_matrix()
    if not has_quaternion:
        return None
    values = _together(columns, QUATERNION)
    norm = np.linalg.norm(values, axis=1)
    if np.abs(norm - 1).max() > UNIT_NORM:
        row = int(np.argmax(np.abs(norm - 1)))
        raise FFGymError(f"Row {row + 1}: the quaternion qw, qx, qy, qz must have norm 1, not {norm[row]:.6g}.")
    return scipy.spatial.transform.Rotation.from_quat(values, scalar_first=True).as_matrix()


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


AT_REST = 0.05
"""Share of the largest speed up to which a table counts as starting or ending at rest; chosen: rows of a log that
begins as the robot does are farther apart than its first movement."""


def follow_table(
    table: MotionTable, t: Array, label: str
) -> Callable[[Array | None, float], JointPath | CartesianPath]:
    """Return a function that samples a table with times `t` at the control step.

    A table that ends at rest is held up to the next sample; one that ends at speed ends with the last sample before.
    """
    points = table.positions if table.joints is None else table.joints
    assert points is not None
    turned = None
    if table.rotations is not None:  # unit quaternions, scalar first, each on the side of the one before, (T, 4)
        # a quaternion and its negative are one rotation; the spline needs one sign throughout
        values = scipy.spatial.transform.Rotation.from_matrix(table.rotations).as_quat(scalar_first=True)
        flips = np.where((values[1:] * values[:-1]).sum(axis=1) < 0, -1.0, 1.0)
        turned = values * np.cumprod(np.append(1.0, flips))[:, None]
    curve, turn = _spline(t, points), None if turned is None else _spline(t, turned)
    held = all(_rests(t, rows)[1] for rows in (points, turned) if rows is not None)

    def evaluate(tau: Array) -> tuple[Array, Array, Array]:
        return _at(curve, tau, t[-1])

    def path(_: Array | None, dt: float) -> JointPath | CartesianPath:
        duration = float(t[-1] if held else dt * np.floor(t[-1] / dt + 1e-9))
        times, *series, phases = sample([Segment(label=label, kind="motion", duration=duration, evaluate=evaluate)], dt)
        if table.joints is not None:
            return JointPath(name=label, t=times, q=series[0], dq=series[1], ddq=series[2], phases=phases)
        return CartesianPath(
            name=label,
            t=times,
            position=series[0],
            velocity=series[1],
            acceleration=series[2],
            phases=phases,
            **({} if turn is None else _turning(*_at(turn, times, t[-1]))),
        )

    return path


def _rests(t: Array, rows: Array) -> tuple[bool, bool]:
    """Tell if rows (T, D) start and end at rest."""
    speed = np.linalg.norm(np.diff(rows, axis=0), axis=1) / np.diff(t)
    return bool(speed[0] <= AT_REST * speed.max()), bool(speed[-1] <= AT_REST * speed.max())


def _spline(t: Array, rows: Array) -> "scipy.interpolate.CubicSpline[Any]":
    """Cubic spline through rows (T, D), at rest at an end where they are."""
    starts, ends = _rests(t, rows)
    return scipy.interpolate.CubicSpline(
        t, rows, bc_type=("clamped" if starts else "not-a-knot", "clamped" if ends else "not-a-knot")
    )


def _at(curve: "scipy.interpolate.CubicSpline[Any]", t: Array, end: float) -> tuple[Array, Array, Array]:
    """Value and derivatives at times `t`; after the end it stays where it is."""
    inside, still = np.minimum(t, end), (t > end)[:, None]
    return curve(inside), np.where(still, 0.0, curve(inside, 1)), np.where(still, 0.0, curve(inside, 2))


def _turning(q: Array, dq: Array, ddq: Array) -> dict[str, Array]:
    r"""Orientation and its rates in world axes, of quaternions of any length and their derivatives, (T, 4) each.

    .. math:: \omega = 2 \operatorname{Im}(\dot q \bar q) / |q|^2
    """
    square = (q * q).sum(axis=1)[:, None]
    velocity = 2 * _imaginary(dq, q) / square
    growth = 2 * (q * dq).sum(axis=1)[:, None] / square
    return {
        "rotation": scipy.spatial.transform.Rotation.from_quat(q, scalar_first=True).as_matrix(),
        "angular_velocity": velocity,
        "angular_acceleration": 2 * _imaginary(ddq, q) / square - growth * velocity,
    }


def _imaginary(a: Array, b: Array) -> Array:
    """Vector of a times the conjugate of b, quaternions (T, 4), shape (T, 3)."""
    product: Array = b[:, :1] * a[:, 1:] - a[:, :1] * b[:, 1:] - np.cross(a[:, 1:], b[:, 1:])
    return product


SPEED = 0.1
"""Default TCP speed through points without times [m/s]; chosen: the fastest of the thesis, (2.16)."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class TablePart(MotionPart):
    """Rows of a CSV file: with times they are followed in time, without they are points of a smooth curve."""

    kind: ClassVar[str] = "table"
    file: str = entry("path of the CSV file, from the folder of the motion file")
    speed: float = entry("of the TCP through poses without times", "m/s", default=SPEED)

    def moves(self, place: PartContext) -> Sequence[Move]:
        """One move."""
        if not isinstance(self.file, str) or not self.file:
            raise FFGymError(f"file = {self.file!r} must be the path of a CSV file.")
        path = place.folder / self.file
        robot = place.robot
        table = parse_table(read_text(path), str(path), robot.joints, robot.kinematics.units)
        speed = check_number("speed", self.speed, unit="m/s", low=0.0, open_low=True)
        named: dict[str, Any] = {"label": self.label or path.stem, "where": place.where}
        if table.t is not None:
            return [MoveTimed(path=follow_table(table, table.t, named["label"]), **named)]
        points = table.positions if table.joints is None else table.joints
        assert points is not None
        same = np.flatnonzero(np.all(np.diff(points, axis=0) == 0, axis=1))
        if same.size:
            raise FFGymError(f"{path}: row {int(same[0]) + 2} repeats the row before; a curve needs points apart.")
        if table.joints is not None:
            return [MoveJointSpline(through=points, **named)]
        rotations = [None] * len(points) if table.rotations is None else list(table.rotations)
        poses = tuple(Pose(position=p, rotation=r) for p, r in zip(points, rotations, strict=True))
        return [MoveSpline(through=poses, speed=Speed(tcp=speed), **named)]
