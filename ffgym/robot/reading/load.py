"""Robots by name or file, and parameter files, whose numbers replace some of a robot's."""

import os
import tomllib
from collections.abc import Mapping
from dataclasses import replace
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

from ffgym.core.errors import FFGymError, check_choice, errors_at
from ffgym.core.files import read_text
from ffgym.core.toml import merge_tables, parse_toml
from ffgym.robot.description import RobotDescription
from ffgym.robot.reading.draft import RobotDraft
from ffgym.robot.reading.parse import parse_draft
from ffgym.robot.reading.quantity import Quantity, parse_quantity
from ffgym.robot.reading.rules import RULES


def builtin_robots() -> tuple[str, ...]:
    """Names of the robots that ship with the package."""
    return tuple(sorted(_builtin("data")))


def builtin_parameters() -> tuple[str, ...]:
    """Names of the parameter files that ship with the package; each is for one of its robots."""
    return tuple(sorted(_builtin("parameters")))


def _builtin(folder: str) -> dict[str, Traversable]:
    """TOML files of a folder of this package, by name."""
    files = (resources.files("ffgym.robot") / folder).iterdir()
    return {Path(file.name).stem: file for file in files if file.name.endswith(".toml")}


def load_robot(robot: str | Path) -> RobotDescription:
    """Read a built-in robot by name, or a description file by path (anything that ends in .toml).

    A parameter file that names its robot, or the name of a built-in one, is that robot with its numbers.

    Raises:
        FFGymError: if there is no such robot or file, or the file does not describe a whole robot.
    """
    return load_draft(robot).complete()


def _draft_of(text: str, place: Path, seen: tuple[Path, ...] = ()) -> RobotDraft:
    """Draft from the text of a description or of a parameter file; `seen` are the parameter files that lead to it."""
    try:
        head = parse_toml(text, str(place)).get("parameters")
    except FFGymError:  # the reading of a description says what is wrong
        head = None
    if not isinstance(head, dict) or not isinstance(head.get("robot"), str):
        return parse_draft(text, where=str(place), folder=place.parent)
    if not isinstance(path := head.get("description"), str):
        known = load_draft(check_choice(f"robot of parameter file {place}", head["robot"], builtin_robots()))
    elif not path.endswith(".toml"):
        raise FFGymError(f"{place}: description = {path!r} must be the path of the robot's description, .toml.")
    elif (seen := (*seen, _real(place))).count(_real(place.parent / path)):
        raise FFGymError(f"{place}: description = {path!r} leads back to a parameter file, must be a description.")
    else:
        known = _draft_of(_read_text(place.parent / path), place.parent / path, seen)
    with errors_at(str(place)):
        tree = _read_tables(text, place, known.description_for("kinematics"))
        return replace(draft_with_numbers(known, tree), where=str(place))


def _real(path: Path) -> Path:
    """Path without links; one that leads to itself stays, and cannot be read."""
    return Path(os.path.realpath(path))


def load_draft(robot: str | Path) -> RobotDraft:
    """Read a description that may lack entries; `robot` as for `load_robot`.

    Raises:
        FFGymError: if there is no such robot or file, or an entry is unknown or invalid.
    """
    if str(robot).endswith(".toml"):
        return _draft_of(_read_text(Path(robot)), Path(robot))
    if Path(robot).suffix in (".xml", ".urdf"):
        raise FFGymError(
            f"{robot} is an arm file, which holds no drives. Make a description of it: ffgym robot new {robot}"
        )
    if str(robot) in builtin_parameters():
        text = _builtin("parameters")[str(robot)].read_text(encoding="utf-8")
        return _draft_of(text, Path(f"{robot}.toml"))
    if (name := str(robot)) not in builtin_robots():
        raise FFGymError(
            f"Unknown robot {name!r}. Available: {', '.join(builtin_robots())}; the same with other numbers: "
            f"{', '.join(builtin_parameters())}."
        )
    return parse_draft(_builtin("data")[name].read_text(encoding="utf-8"), where=f"{name}.toml")


def robot_of(robot: RobotDescription | str | Path, what: str = "robot") -> RobotDescription:
    """Return a description as it is, or the one that a name or a path leads to; `what` names it in errors.

    Raises:
        FFGymError: if it is none of these.
    """
    if isinstance(robot, RobotDescription):
        return robot
    if not isinstance(robot, str | Path):
        raise FFGymError(
            f"{what} = {robot!r} must be a RobotDescription, one of {', '.join(builtin_robots())}, or a path to a "
            f".toml file."
        )
    return load_robot(robot)


def parse_robot(text: str, where: str = "description", folder: str | Path = ".") -> RobotDescription:
    """Build a description from TOML text.

    Args:
        text: the description.
        where: its name, for messages.
        folder: where the path of an arm file starts.

    Raises:
        FFGymError: if the text is not TOML, or an entry is missing, unknown or invalid.
    """
    return parse_draft(text, where, folder).complete()


def _read_text(path: Path) -> str:
    try:
        return read_text(path)
    except FFGymError as error:
        raise FFGymError(f"Robot description {error} Built-in robots: {', '.join(builtin_robots())}.") from error


GROUPS = {"friction": "friction", "drive": "drive", "links": "bodies", "tool": "tool"}
"""Tables of physics that can be identified, and the part of the description that each goes to."""

_TABLES = {**GROUPS, "servo": "servo"}
"""Tables of a parameter file: gains of the servo beside them. Geometry and sample times are known by design and stay in
the description."""

ENTRIES = tuple(path for path in RULES if path.split(".")[0] in _TABLES and path != "servo.control_dt")
"""Entries that a parameter file may have."""


def with_parameters(robot: RobotDescription, path: str | Path) -> RobotDescription:
    """Return the robot with the numbers of a parameter file in place of its own.

    The file is TOML with any of the tables [friction.*], [drive.*], [links.*], [tool.*] and gains [servo.*] as in a
    robot description, and maybe [parameters] with the name of the `robot` they belong to, a `title`, the path of its
    `description`, and `with`, a list of built-in parameter files whose numbers hold where this file has none; of two
    that have the same number, the later one holds.

    Raises:
        FFGymError: if the file cannot be read, is for another robot, or an entry is unknown or invalid.
    """
    try:
        text = read_text(path)
    except FFGymError as error:
        raise FFGymError(f"Cannot read parameter file {error}") from error
    with errors_at(str(path)):
        return with_numbers(robot, _read_tables(text, path, robot))


def draft_with_numbers(draft: RobotDraft, tree: Mapping[str, Any]) -> RobotDraft:
    """Return a description that may lack entries with the numbers of parsed TOML tables, as in a parameter file."""
    found = _parse(tree, draft.description_for("kinematics"))
    changed = replace(draft, quantities={**draft.quantities, **found})
    changed.check()
    return changed


def with_numbers(robot: RobotDescription, tree: Mapping[str, Any]) -> RobotDescription:
    """Return the robot with the numbers of parsed TOML tables, as in a parameter file, in place of its own."""
    quantities = _parse(tree, robot)
    parts: dict[str, Any] = {}
    for group, attribute in _TABLES.items():
        found = {
            path.removeprefix(f"{group}."): q.value for path, q in quantities.items() if path.startswith(f"{group}.")
        }
        if found:
            values = {name: value if value.ndim else float(value) for name, value in found.items()}
            parts[attribute] = replace(getattr(robot, attribute), **values)
    return replace(robot, **parts, quantities=dict(robot.quantities) | quantities)


def _read_tables(text: str, place: str | Path, robot: RobotDescription) -> dict[str, Any]:
    """Read the tables of a parameter file for a robot, with those of the files that it is to be taken `with`."""
    tree = parse_toml(text, f"Cannot read parameter file {place}: it")
    head = tree.pop("parameters", {})
    if not isinstance(head, dict) or not set(head) <= {"robot", "title", "description", "with"}:
        raise FFGymError(f"[parameters] may have robot, title, description and with, got {head!r}.")
    if head.get("robot", robot.name) != robot.name:
        raise FFGymError(f"[parameters] are for robot {head['robot']!r}, not for {robot.name!r}.")
    if not isinstance(names := head.get("with", []), list):
        raise FFGymError(f"with = {names!r} in [parameters] must be a list of built-in parameter files.")
    # numbers of other files first; one of those may not name others in turn, so that no file leads back to itself
    base: dict[str, Any] = {}
    for name in names:
        file = _builtin("parameters")[check_choice("with in [parameters]", name, builtin_parameters())]
        more = tomllib.loads(file.read_text(encoding="utf-8"))
        head = more.pop("parameters")
        if head["robot"] != robot.name or "with" in head:
            raise FFGymError(f"with = [{name!r}] in [parameters] must name files of numbers for {robot.name!r}.")
        base = merge_tables(base, more)
    return merge_tables(base, tree)


def _parse(tree: Mapping[str, Any], robot: RobotDescription) -> dict[str, Quantity]:
    entries = {
        f"{group}.{name}": table
        for group, tables in tree.items()
        for name, table in (tables.items() if isinstance(tables, dict) else [("", tables)])
    }
    unknown = sorted(set(entries) - set(ENTRIES))
    if unknown:
        raise FFGymError(f"Unknown entries {unknown}. A parameter file may have: {', '.join(sorted(ENTRIES))}.")
    if not entries:
        raise FFGymError(f"There are no parameters. A parameter file may have: {', '.join(sorted(ENTRIES))}.")
    if robot.tool is None and any(path.startswith("tool.") for path in entries):
        raise FFGymError(f"Robot {robot.name!r} has no tool to give parameters to.")
    types, gears = robot.kinematics.types, robot.drive.gear_ratio
    if ratio := entries.get("drive.gear_ratio"):
        gears = parse_quantity("drive.gear_ratio", ratio, RULES["drive.gear_ratio"], types, gears).value
    return {path: parse_quantity(path, table, RULES[path], types, gears) for path, table in entries.items()}
