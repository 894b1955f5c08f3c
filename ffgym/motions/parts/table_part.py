"""A part that is a table in a CSV file: poses or joint positions, with times or without."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, final

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation, RotationSpline

from ffgym.errors import FFGymError, check_number
from ffgym.files import read_text
from ffgym.motions.parts.part import Part, entry
from ffgym.motions.parts.place import Place
from ffgym.motions.table import Table, parse_table
from ffgym.paths.motion import CartesianPath, JointPath, Segment, sample
from ffgym.paths.moves import Move, MoveJointSpline, MoveSpline, MoveTimed, Pose, Speed
from ffgym.types import Array

SPEED = 0.1
"""Default TCP speed through points without times [m/s]; chosen: the fastest of the thesis, (2.16)."""
AT_REST = 0.05
"""Share of the largest speed up to which a table counts as starting or ending at rest; chosen: rows of a log that
begins as the robot does are farther apart than its first movement."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class TablePart(Part):
    """Rows of a CSV file: with times they are followed in time, without they are points of a smooth curve."""

    kind: ClassVar[str] = "table"
    file: str = entry("path of the CSV file, from the folder of the motion file")
    speed: float = entry("of the TCP through poses without times", "m/s", default=SPEED)

    def moves(self, place: Place) -> Sequence[Move]:
        """One move."""
        if not isinstance(self.file, str) or not self.file:
            raise FFGymError(f"file = {self.file!r} must be the path of a CSV file.")
        path = place.folder / self.file
        robot = place.robot
        table = parse_table(read_text(path), str(path), robot.joints, robot.kinematics.units)
        speed = check_number("speed", self.speed, unit="m/s", low=0.0, open_low=True)
        return [table_move(table, speed, label=self.label or path.stem, where=place.where)]


def table_move(table: Table, speed: float, *, label: str, where: str) -> Move:
    """Move along the rows of a table; `speed` [m/s] is that of the TCP through poses without times."""
    if table.t is not None:
        return MoveTimed(path=_followed(table, table.t, label), label=label, where=where)
    if table.joints is not None:
        _check_apart(table, table.joints)
        return MoveJointSpline(through=table.joints, label=label, where=where)
    assert table.positions is not None
    _check_apart(table, table.positions)
    rotations = [None] * len(table.positions) if table.rotations is None else list(table.rotations)
    poses = tuple(Pose(position=p, rotation=r) for p, r in zip(table.positions, rotations, strict=True))
    return MoveSpline(through=poses, speed=Speed(tcp=speed), label=label, where=where)


def _check_apart(table: Table, points: Array) -> None:
    same = np.flatnonzero(np.all(np.diff(points, axis=0) == 0, axis=1))
    if same.size:
        raise FFGymError(f"{table.name}: row {int(same[0]) + 2} repeats the row before; a curve needs points apart.")


def _followed(table: Table, t: Array, label: str) -> Callable[[Array | None, float], JointPath | CartesianPath]:
    """What samples a table with times at the control step, by splines that are twice continuously differentiable."""
    points = table.positions if table.joints is None else table.joints
    assert points is not None
    curve = _spline(t, points)
    turn = None if table.rotations is None else RotationSpline(t, Rotation.from_matrix(table.rotations))

    def evaluate(tau: Array) -> tuple[Array, Array, Array]:
        inside = np.minimum(tau, t[-1])
        return curve(inside), curve(inside, 1), curve(inside, 2)

    def path(_: Array | None, dt: float) -> JointPath | CartesianPath:
        segment = Segment(label=label, kind="motion", duration=float(t[-1]), evaluate=evaluate)
        times, position, velocity, acceleration, phases = sample([segment], dt)
        if table.joints is not None:
            return JointPath(name=label, t=times, q=position, dq=velocity, ddq=acceleration, phases=phases)
        return CartesianPath(
            name=label,
            t=times,
            position=position,
            velocity=velocity,
            acceleration=acceleration,
            phases=phases,
            **_turning(turn, np.minimum(times, t[-1])),
        )

    return path


def _spline(t: Array, points: Array) -> CubicSpline[Any]:
    """Cubic spline through rows (T, D), at rest at an end where they are."""
    speed = np.linalg.norm(np.diff(points, axis=0), axis=1) / np.diff(t)
    starts, ends = (bool(speed[end] <= AT_REST * speed.max()) for end in (0, -1))
    return CubicSpline(t, points, bc_type=("clamped" if starts else "not-a-knot", "clamped" if ends else "not-a-knot"))


def _turning(turn: RotationSpline | None, t: Array) -> dict[str, Array]:
    """Orientation and its rates in world axes; scipy gives the rates in the axes of the tool."""
    if turn is None:
        return {}
    rotation = turn(t)
    return {
        "rotation": rotation.as_matrix(),
        "angular_velocity": rotation.apply(turn(t, 1)),
        "angular_acceleration": rotation.apply(turn(t, 2)),
    }
