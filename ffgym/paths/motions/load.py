"""Motions by name or from a file, as references for a robot."""

from collections.abc import Callable, Mapping
from dataclasses import fields
from functools import partial
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from ffgym.core.errors import FFGymError, check_choice, check_number, check_shape, errors_at
from ffgym.core.files import read_text
from ffgym.core.toml import parse_toml
from ffgym.core.types import Array
from ffgym.paths.circles import DWELL
from ffgym.paths.limits import MotionLimits
from ffgym.paths.motions.composition import Motion, compose, rapid_motion
from ffgym.paths.motions.joint_parts import JointsPart, LadderPart, MultisinePart, SinePart, TrianglePart, WaitPart
from ffgym.paths.motions.part import Part, Place, joint_values, named_point
from ffgym.paths.motions.table_part import TablePart
from ffgym.paths.motions.tool_parts import ArcPart, CirclePart, CircleTestPart, LinePart, SplinePart
from ffgym.paths.moves import Move
from ffgym.robot import RigidArm, RobotDescription

PARTS: Mapping[str, type[Part]] = MappingProxyType(
    {
        part.kind: part
        for part in (
            LinePart,
            ArcPart,
            CirclePart,
            SplinePart,
            CircleTestPart,
            JointsPart,
            WaitPart,
            TablePart,
            SinePart,
            MultisinePart,
            LadderPart,
            TrianglePart,
        )
    }
)
"""Parts by what a file calls them."""


HEAD: Mapping[str, str] = {
    "name": "name of the motion, for recordings; absent is that of the file",
    "origin": "point that coordinates count from: [x, y, z] in m, or the name of a point of the work area, of which "
    "'work_area' is the first; absent is the world's origin",
    "start": "joint positions at the start, as `to` of a joints part; absent starts at the first target",
    "dwell": "rest before and after the motion in s; absent is 0.3, and a part that brings its own rests gets none",
    "limits": "table of the limits below, those that differ from the defaults",
    "part": "the parts, in order",
}
"""What a motion file may say, and what it means."""

_PER_JOINT = ("joint_acceleration", "joint_jerk")


def read_motion_file(arm: RigidArm, path: Path) -> Motion:
    """Motion of a TOML file for a robot.

    Raises:
        FFGymError: if the file cannot be read or is no motion file, or the robot cannot make the motion.
    """
    return parse_motion(arm, read_text(path), where=str(path), name=path.stem, folder=path.parent)


def parse_motion(arm: RigidArm, text: str, *, where: str, name: str, folder: Path | None = None) -> Motion:
    """Motion from TOML text; `where` names the text in messages, `name` the motion if the text does not.

    Files that it names are looked for in `folder`.

    Raises:
        FFGymError: if the text is no motion file, or the robot cannot make the motion.
    """
    tree = parse_toml(text, where)
    with errors_at(where):
        head = _head(arm.robot, tree, name)
        moves = _moves(arm, tree, where, folder or Path())
    return compose(arm, moves, **head)


def _head(robot: RobotDescription, tree: Mapping[str, Any], name: str) -> dict[str, Any]:
    """Arguments of `compose` but the moves."""
    unknown = sorted(set(tree) - set(HEAD))
    if unknown:
        raise FFGymError(f"Unknown entries {', '.join(unknown)}. A motion file has {', '.join(HEAD)}.")
    given = tree.get("name", name)
    if not isinstance(given, str) or not given:
        raise FFGymError(f"name = {given!r} must be text.")
    start = tree.get("start")
    return {
        "name": given,
        "start": None if start is None else joint_values(robot, "start", start, _span(robot)),
        "dwell": check_number("dwell", tree.get("dwell", DWELL), unit="s", low=0.0),
        "limits": _limits(robot, tree.get("limits", {})),
    }


def _limits(robot: RobotDescription, table: Any) -> MotionLimits:
    if not isinstance(table, dict):
        raise FFGymError(f"[limits] must be a table, got {table!r}.")
    known = [f.name for f in fields(MotionLimits)]
    for key in table:
        check_choice("limit", key, known)
    values = dict(table)
    for key in _PER_JOINT:
        if key in values:
            values[key] = joint_values(robot, f"limits.{key}", values[key], robot.kinematics.max_speed)
    return MotionLimits(**values)


def _moves(arm: RigidArm, tree: Mapping[str, Any], where: str, folder: Path) -> list[Move]:
    parts = tree.get("part")
    if not isinstance(parts, list) or not parts or not all(isinstance(part, dict) for part in parts):
        raise FFGymError("A motion file needs parts, each a table that begins with [[part]].")
    origin = _origin(arm.robot, tree.get("origin"))
    moves: list[Move] = []
    for i, table in enumerate(parts, start=1):
        entries = dict(table)
        kind = entries.pop("kind", None)
        here = f"{where}: part {i}" + (f" ({kind})" if kind else "")
        place = Place(arm=arm, origin=origin, where=here, folder=folder)
        with errors_at(here):
            moves += PARTS[check_choice("kind of part", kind, list(PARTS))].parse(entries).moves(place)
    return moves


def _origin(robot: RobotDescription, value: Any) -> Array:
    if value is None:
        return np.zeros(3)
    return named_point(robot, value) if isinstance(value, str) else check_shape("origin", value, (3,))


def _span(robot: RobotDescription) -> Array:
    return np.diff(robot.kinematics.range, axis=1)[:, 0]


def read_csv(arm: RigidArm, path: Path) -> Motion:
    """Motion of a CSV file of poses or joint positions, see `TablePart`.

    Raises:
        FFGymError: if the file cannot be read or is no such table, or the robot cannot make the motion.
    """
    place = Place(arm=arm, origin=np.zeros(3), where=str(path), folder=path.parent)
    return compose(arm, TablePart(file=path.name).moves(place), name=path.stem)


READERS: Mapping[str, Callable[[RigidArm, Path], Motion]] = MappingProxyType(
    {".toml": read_motion_file, ".csv": read_csv, ".mod": rapid_motion, ".prg": rapid_motion}
)
"""What reads a file, by the suffix of its name."""

PROGRAMS = tuple(suffix for suffix, reader in READERS.items() if reader is rapid_motion)
"""Suffixes of files with procedures."""

FOLDERS = (("ffgym.paths.motions", "data"), ("ffgym.paths.rapid", "examples"))
"""Where built-in motions are: packages and folders in them."""


def list_motions() -> tuple[str, ...]:
    """Names of the motions that ship with the package; which of them a robot can make depends on it."""
    return tuple(sorted(builtin_files()))


def builtin_files() -> dict[str, Traversable]:
    """Files of the built-in motions, by name."""
    files = [file for package, folder in FOLDERS for file in (resources.files(package) / folder).iterdir()]
    return {Path(file.name).stem: file for file in files if Path(file.name).suffix in READERS}


def load_motion(arm: RigidArm, source: str | Path, *, entry: str | None = None) -> Motion:
    """Motion for a robot, from a built-in name or from a file.

    Args:
        arm: the robot.
        source: a name of `list_motions`, or a path whose suffix is one of READERS.
        entry: procedure of a RAPID program that is run; None takes main, or the only one.

    Raises:
        FFGymError: if there is no such motion or file, it has no procedure `entry`, or the robot cannot make it.
    """
    path = Path(source)
    if path.suffix.lower() in READERS:
        return _reader(path.name, entry)(arm, path)
    if path.suffix or path.name != str(source):
        raise FFGymError(f"{source}: a motion file must end in {', '.join(READERS)}.")
    file = builtin_files()[check_choice("motion", str(source), list_motions())]
    reader = _reader(file.name, entry)
    if file.name.endswith(".toml"):
        return parse_motion(arm, file.read_text(encoding="utf-8"), where=file.name, name=str(source))
    with resources.as_file(file) as place:
        return reader(arm, place)


def _reader(name: str, entry: str | None) -> Callable[[RigidArm, Path], Motion]:
    """What reads a file of that name, from procedure `entry` on if one is given."""
    suffix = Path(name).suffix.lower()
    if entry is None:
        return READERS[suffix]
    if suffix not in PROGRAMS:
        raise FFGymError(
            f"entry = {entry!r} is a procedure of a program ({', '.join(PROGRAMS)}), which {name} is not; leave it out."
        )
    return partial(rapid_motion, entry=entry)
