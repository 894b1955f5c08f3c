"""Robots by name or file; every number is checked for unit, side, shape, range and origin."""

from importlib import resources
from pathlib import Path

from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.files import read_text
from ffgym.robot.description import RobotDescription
from ffgym.robot.reading.draft import RobotDraft
from ffgym.robot.reading.parameters import (
    description_of_parameters,
    draft_with_parameters,
    parse_parameters,
    robot_of_parameters,
)
from ffgym.robot.reading.parse import parse_draft


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
