"""Motions by name or from a file, as references for a robot."""

from collections.abc import Mapping
from dataclasses import fields
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from ffgym.core.errors import FFGymError, check_choice, check_class, check_number, check_shape, errors_at
from ffgym.core.files import read_text
from ffgym.core.toml import parse_toml
from ffgym.paths.circles import DWELL
from ffgym.paths.limits import MotionLimits
from ffgym.paths.motions.composition import Motion, compose, rapid_motion
from ffgym.paths.motions.joint_parts import JointsPart, LadderPart, MultisinePart, SinePart, TrianglePart, WaitPart
from ffgym.paths.motions.part import MotionPart, PartContext, find_point
from ffgym.paths.motions.table_part import TablePart
from ffgym.paths.motions.tool_parts import ArcPart, CirclePart, CircleTestPart, LinePart, SplinePart
from ffgym.paths.moves import Move
from ffgym.robot import RigidArm

PARTS: Mapping[str, type[MotionPart]] = MappingProxyType(
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
"""Entries of a motion file, with their meaning."""


MOST_PARTS = 2000
"""Most parts of a motion file; chosen: each takes some milliseconds to be composed."""


def parse_motion(arm: RigidArm, text: str, *, where: str, name: str, folder: Path | None = None) -> Motion:
    """Motion from TOML text; `where` names the text in messages, `name` the motion if the text does not.

    Files that it names are looked for in `folder`.
    """
    tree = parse_toml(text, where)
    with errors_at(where):
        head = _head(PartContext(arm=arm, origin=np.zeros(3), where=where), tree, name)
        moves = _moves(arm, tree, where, folder or Path())
    return compose(arm, moves, **head)


def _head(place: PartContext, tree: Mapping[str, Any], name: str) -> dict[str, Any]:
    """Arguments of `compose` but the moves."""
    unknown = sorted(set(tree) - set(HEAD))
    if unknown:
        raise FFGymError(f"Unknown entries {', '.join(unknown)}. A motion file has {', '.join(HEAD)}.")
    given = tree.get("name", name)
    if not isinstance(given, str) or not given:
        raise FFGymError(f"name = {given!r} must be text.")
    start = tree.get("start")
    if start is not None:
        start = place.joints("start", start, place.span)
    dwell = check_number("dwell", tree.get("dwell", DWELL), unit="s", low=0.0)
    limits = tree.get("limits", {})
    if not isinstance(limits, dict):
        raise FFGymError(f"[limits] must be a table, got {limits!r}.")
    values: dict[str, Any] = {}
    for key in limits:
        check_choice("limit", key, [f.name for f in fields(MotionLimits)])
    for key, value in limits.items():
        per_joint = key in ("joint_acceleration", "joint_jerk")
        fastest = place.robot.kinematics.max_speed
        values[key] = place.joints(f"limits.{key}", value, fastest) if per_joint else value
    return {"name": given, "start": start, "dwell": dwell, "limits": MotionLimits(**values)}


def _moves(arm: RigidArm, tree: Mapping[str, Any], where: str, folder: Path) -> list[Move]:
    parts = tree.get("part")
    if not isinstance(parts, list) or not parts or not all(isinstance(part, dict) for part in parts):
        raise FFGymError("A motion file needs parts, each a table that begins with [[part]].")
    if len(parts) > MOST_PARTS:
        raise FFGymError(
            f"It has {len(parts)} parts, must have {MOST_PARTS} at most; a long path is a table or a program."
        )
    origin = tree.get("origin", [0.0, 0.0, 0.0])
    origin = find_point(arm.robot, origin) if isinstance(origin, str) else check_shape("origin", origin, (3,))
    moves: list[Move] = []
    for i, table in enumerate(parts, start=1):
        entries = dict(table)
        kind = entries.pop("kind", None)
        here = f"{where}: part {i}" + (f" ({kind})" if kind else "")
        place = PartContext(arm=arm, origin=origin, where=here, folder=folder)
        with errors_at(here):
            moves += PARTS[check_choice("kind of part", kind, list(PARTS))].parse(entries).moves(place)
    return moves


PROGRAMS = (".mod", ".prg", ".pgf")
"""Suffixes of files with procedures."""

READERS = (".toml", ".csv", *PROGRAMS)
"""Suffixes of files that hold a motion."""

FOLDERS = (("ffgym.paths.motions", "data"), ("ffgym.paths.rapid", "examples"))
"""Places of built-in motions: packages and folders in them."""


def list_motions() -> tuple[str, ...]:
    """Names of the motions that ship with the package; which of them a robot can make depends on it."""
    return tuple(sorted(builtin_files()))


def builtin_files() -> dict[str, Traversable]:
    """Files of the built-in motions, by name."""
    files = [file for package, folder in FOLDERS for file in (resources.files(package) / folder).iterdir()]
    return {Path(file.name).stem: file for file in files if Path(file.name).suffix in READERS}


def is_program(source: str) -> bool:
    """Tell if a name of `list_motions` or a path is that of a program, of which a procedure is run."""
    file = builtin_files().get(source)
    return Path(source if file is None else file.name).suffix.lower() in PROGRAMS


def load_motion(
    arm: RigidArm,
    source: str | Path,
    *,
    entry: str | None = None,
    inputs: Mapping[str, float] | None = None,
    cycles: int = 1,
) -> Motion:
    """Motion for a robot, from a built-in name or from a file.

    Args:
        arm: the robot.
        source: a name of `list_motions`, or a path whose suffix is one of READERS.
        entry: procedure of a RAPID program that is run; None takes main, or the only one.
        inputs: values of inputs of a program by name; others are 0 until it waits for them.
        cycles: passes through a loop of a program that never ends.

    Raises:
        FFGymError: if there is no such motion or file, it has no procedure `entry`, or the robot cannot make it.
    """
    check_class("arm", arm, RigidArm, "RigidArm(robot) makes one of a description")
    how = {"entry": entry, "inputs": inputs or None, "cycles": cycles if cycles != 1 else None}
    program = {name: value for name, value in how.items() if value is not None}
    path = Path(source)
    if path.suffix.lower() in READERS:
        return _read(arm, path, str(path), program)
    if path.suffix or path.name != str(source):
        raise FFGymError(f"{source}: a motion file must end in {', '.join(READERS)}.")
    file = builtin_files()[check_choice("motion", str(source), list_motions())]
    with resources.as_file(file) as path:
        return _read(arm, path, file.name, program)


def _read(arm: RigidArm, path: Path, where: str, program: dict[str, Any]) -> Motion:
    """Motion of a file that `where` names in messages; `program` says how a program is run."""
    suffix = path.suffix.lower()
    if suffix in PROGRAMS:
        return rapid_motion(arm, path, **program)
    if program:
        name, value = next(iter(program.items()))
        raise FFGymError(
            f"{name} = {value!r} is for a program ({', '.join(PROGRAMS)}), which {path.name} is not; leave it out."
        )
    if suffix == ".toml":
        return parse_motion(arm, read_text(path), where=where, name=path.stem, folder=path.parent)
    place = PartContext(arm=arm, origin=np.zeros(3), where=where, folder=path.parent)
    return compose(arm, TablePart(file=path.name).moves(place), name=path.stem)
