"""Motion files: TOML with a name, limits, and parts that follow each other."""

import tomllib
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from ffgym.core.errors import FFGymError, check_choice, check_number, check_shape
from ffgym.core.files import read_text
from ffgym.core.types import Array
from ffgym.paths.circles import DWELL
from ffgym.paths.limits import MotionLimits
from ffgym.paths.motions.composition import compose
from ffgym.paths.motions.motion import Motion
from ffgym.paths.motions.parts import PARTS, Place
from ffgym.paths.motions.parts.place import joint_values, named_point
from ffgym.paths.moves import Move
from ffgym.robot import RigidArm, RobotDescription

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
    try:
        tree = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise FFGymError(f"{where} is not valid TOML: {error}.") from error
    try:
        head = _head(arm.robot, tree, name)
        moves = _moves(arm, tree, where, folder or Path())
    except FFGymError as error:
        raise error if str(error).startswith(where) else FFGymError(f"{where}: {error}") from error
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
        try:
            moves += PARTS[check_choice("kind of part", kind, list(PARTS))].parse(entries).moves(place)
        except FFGymError as error:
            raise FFGymError(f"{here}: {error}") from error
    return moves


def _origin(robot: RobotDescription, value: Any) -> Array:
    if value is None:
        return np.zeros(3)
    return named_point(robot, value) if isinstance(value, str) else check_shape("origin", value, (3,))


def _span(robot: RobotDescription) -> Array:
    return np.diff(robot.kinematics.range, axis=1)[:, 0]
