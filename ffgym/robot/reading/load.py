"""Robots by name or file, and parameter files, whose numbers replace some of a robot's."""

import tomllib
from collections.abc import Mapping
from dataclasses import replace
from importlib import resources
from pathlib import Path
from typing import Any

from ffgym.core.errors import FFGymError, check_choice, errors_at
from ffgym.core.files import read_text
from ffgym.core.toml import parse_toml
from ffgym.core.types import Array
from ffgym.robot.description import RobotDescription
from ffgym.robot.reading.draft import RobotDraft
from ffgym.robot.reading.parse import parse_draft
from ffgym.robot.reading.quantity import JointFrame, Quantity, parse_quantity
from ffgym.robot.reading.rules import RULES


def builtin_robots() -> tuple[str, ...]:
    """Names of the robots that ship with the package."""
    return _names("data")


def builtin_parameters() -> tuple[str, ...]:
    """Names of the parameter files that ship with the package; each is for one of its robots."""
    return _names("parameters")


def _names(folder: str) -> tuple[str, ...]:
    files = (resources.files("ffgym.robot") / folder).iterdir()
    return tuple(sorted(Path(f.name).stem for f in files if f.name.endswith(".toml")))


def load_robot(robot: str | Path) -> RobotDescription:
    """Read a built-in robot by name, or a description file by path (anything that ends in .toml).

    A parameter file that names its robot, or the name of a built-in one, is that robot with its numbers.

    Raises:
        FFGymError: if there is no such robot or file, or the file does not describe a whole robot.
    """
    if str(robot) in builtin_parameters():
        text = (resources.files("ffgym.robot") / "parameters" / f"{robot}.toml").read_text(encoding="utf-8")
        return _with_parameters(text, f"{robot}.toml")
    if str(robot).endswith(".toml"):
        text = _read_text(Path(robot))
        if robot_of_parameters(text) is not None:
            return _with_parameters(text, str(robot))
    return load_draft(robot).complete()


def _with_parameters(text: str, where: str) -> RobotDescription:
    """The robot that a parameter file names, with its numbers."""
    known = _draft_of_parameters(text, Path(where))
    if known.missing:
        return draft_with_parameters(known, text, where).complete()
    return parse_parameters(known.complete(), text, where)


def _draft_of_parameters(text: str, place: Path, seen: tuple[Path, ...] = ()) -> RobotDraft:
    """The robot of a parameter file without its numbers: that of the description it names, or a built-in one."""
    if (path := description_of_parameters(text)) is None:
        name = check_choice(f"robot of parameter file {place}", str(robot_of_parameters(text)), builtin_robots())
        return load_draft(name)
    if not path.endswith(".toml"):
        raise FFGymError(f"{place}: description = {path!r} must be the path of the robot's description, .toml.")
    if (seen := (*seen, place.resolve())).count((place.parent / path).resolve()):
        raise FFGymError(f"{place}: description = {path!r} leads back to a parameter file, must be a description.")
    return _draft_at(place.parent / path, seen)


def _draft_at(place: Path, seen: tuple[Path, ...] = ()) -> RobotDraft:
    """Description or parameter file at a path; `seen` are the parameter files that lead to it."""
    text = _read_text(place)
    if robot_of_parameters(text) is not None:
        return draft_with_parameters(_draft_of_parameters(text, place, seen), text, str(place))
    return parse_draft(text, where=str(place), folder=place.parent)


def load_draft(robot: str | Path) -> RobotDraft:
    """Read a description that may lack entries; `robot` as for `load_robot`.

    Raises:
        FFGymError: if there is no such robot or file, or an entry is unknown or invalid.
    """
    if str(robot).endswith(".toml"):
        return _draft_at(Path(robot))
    if Path(robot).suffix in (".xml", ".urdf"):
        raise FFGymError(
            f"{robot} is an arm file, which says nothing of drives. Make a description of it: ffgym robot new {robot}"
        )
    name = check_choice("robot", str(robot), builtin_robots())
    text = (resources.files("ffgym.robot") / "data" / f"{name}.toml").read_text(encoding="utf-8")
    return parse_draft(text, where=f"{name}.toml")


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
"""What a parameter file may hold, and the part of the description it goes to: physics that can be identified. Geometry,
servo and sample times are known by design and stay in the description."""


def with_parameters(robot: RobotDescription, path: str | Path) -> RobotDescription:
    """Return the robot with the numbers of a parameter file in place of its own.

    The file is TOML with any of the tables [friction.*], [drive.*], [links.*] and [tool.*] as in a robot description,
    and maybe [parameters] with the name of the `robot` they belong to, a `title`, and the path of its `description`.

    Raises:
        FFGymError: if the file cannot be read, is for another robot, or an entry is unknown or invalid.
    """
    try:
        text = read_text(path)
    except FFGymError as error:
        raise FFGymError(f"Cannot read parameter file {error}") from error
    return parse_parameters(robot, text, str(path))


def parse_parameters(robot: RobotDescription, text: str, where: str) -> RobotDescription:
    """Return the robot with the numbers of the text of a parameter file; `where` names it in messages.

    Raises:
        FFGymError: if the text is no parameter file, is for another robot, or an entry is unknown or invalid.
    """
    tree = parse_toml(text, f"Cannot read parameter file {where}: it")
    with errors_at(where):
        _check_head(tree.pop("parameters", {}), robot)
        return with_numbers(robot, tree)


def robot_of_parameters(text: str) -> str | None:
    """Name of the robot that a parameter file is for; None if the text is no parameter file, or does not say."""
    return _head_entry(text, "robot")


def description_of_parameters(text: str) -> str | None:
    """Path of the description that a parameter file belongs to, from its own folder; None if it does not say."""
    return _head_entry(text, "description")


def _head_entry(text: str, key: str) -> str | None:
    try:
        head = tomllib.loads(text).get("parameters")
    except (tomllib.TOMLDecodeError, RecursionError):
        return None
    value = head.get(key) if isinstance(head, dict) else None
    return value if isinstance(value, str) else None


def draft_with_parameters(draft: RobotDraft, text: str, where: str) -> RobotDraft:
    """Return a description that may lack entries with the numbers of the text of a parameter file.

    Raises:
        FFGymError: as `parse_parameters`.
    """
    tree = parse_toml(text, f"Cannot read parameter file {where}: it")
    with errors_at(where):
        _check_head(tree.pop("parameters", {}), draft.description_for("kinematics"))
        return replace(draft_with_numbers(draft, tree), where=where)


def draft_with_numbers(draft: RobotDraft, tree: Mapping[str, Any]) -> RobotDraft:
    """Return a description that may lack entries with the numbers of parsed TOML tables, as in a parameter file.

    Raises:
        FFGymError: if an entry is unknown or invalid.
    """
    found = _parsed(tree, draft.description_for("kinematics"))
    changed = replace(draft, quantities={**draft.quantities, **found})
    changed.check()
    return changed


def with_numbers(robot: RobotDescription, tree: Mapping[str, Any]) -> RobotDescription:
    """Return the robot with the numbers of parsed TOML tables, as in a parameter file, in place of its own.

    Raises:
        FFGymError: if an entry is unknown or invalid.
    """
    return _replaced(robot, _parsed(tree, robot))


def _check_head(head: Any, robot: RobotDescription) -> None:
    if not isinstance(head, dict) or not set(head) <= {"robot", "title", "description"}:
        raise FFGymError(f"[parameters] may have robot and title, and a description, got {head!r}.")
    if head.get("robot", robot.name) != robot.name:
        raise FFGymError(f"[parameters] are for robot {head['robot']!r}, not for {robot.name!r}.")


def _parsed(tree: Mapping[str, Any], robot: RobotDescription) -> dict[str, Quantity]:
    entries = {
        f"{group}.{name}": table
        for group, tables in tree.items()
        for name, table in (tables.items() if isinstance(tables, dict) else [("", tables)])
    }
    known = [path for path in RULES if path.split(".")[0] in GROUPS]
    unknown = sorted(set(entries) - set(known))
    if unknown:
        raise FFGymError(f"Unknown entries {unknown}. A parameter file may have: {', '.join(sorted(known))}.")
    if not entries:
        raise FFGymError(f"There are no parameters. A parameter file may have: {', '.join(sorted(known))}.")
    if robot.tool is None and any(path.startswith("tool.") for path in entries):
        raise FFGymError(f"Robot {robot.name!r} has no tool to give parameters to.")
    joints = JointFrame(types=robot.kinematics.types, gear_ratio=robot.drive.gear_ratio)
    if ratio := entries.get("drive.gear_ratio"):
        parsed = parse_quantity("drive.gear_ratio", ratio, RULES["drive.gear_ratio"], joints)
        joints = JointFrame(types=joints.types, gear_ratio=parsed.value)
    return {path: parse_quantity(path, table, RULES[path], joints) for path, table in entries.items()}


def _replaced(robot: RobotDescription, quantities: Mapping[str, Quantity]) -> RobotDescription:
    parts: dict[str, Any] = {}
    for group, attribute in GROUPS.items():
        values = {path.split(".")[1]: _value(q.value) for path, q in quantities.items() if path.split(".")[0] == group}
        if values:
            parts[attribute] = replace(getattr(robot, attribute), **values)
    return replace(robot, **parts, quantities=dict(robot.quantities) | dict(quantities))


def _value(array: Array) -> Array | float:
    return array if array.ndim else float(array)
