"""A part that is a table in a CSV file: poses or joint positions, with times or without."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from ffgym.core.errors import FFGymError, check_number
from ffgym.core.files import read_text
from ffgym.core.types import Array
from ffgym.paths.motions.parts.part import Part, entry
from ffgym.paths.motions.parts.place import Place
from ffgym.paths.motions.parts.timed_rows import followed
from ffgym.paths.motions.table import Table, parse_table
from ffgym.paths.moves import Move, MoveJointSpline, MoveSpline, MoveTimed, Pose, Speed

SPEED = 0.1
"""Default TCP speed through points without times [m/s]; chosen: the fastest of the thesis, (2.16)."""


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
        return MoveTimed(path=followed(table, table.t, label), label=label, where=where)
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
