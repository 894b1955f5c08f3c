"""Machine files: a robot as it is, in TOML: its robot, other numbers than the description's, effects, climate.

.. code:: toml

    [machine]                      # title, and robot: a built-in name, or the path of a description from here
    [friction.*], [drive.*], ...   # as in a parameter file: numbers in place of the description's
    [effects.<name>]               # see docs/effects; every parameter has value, unit and maybe source
    [climate]                      # ambient, rise, time_constant and running_since, in the same way

docs/machine_files.md has an example.
"""

from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.files import read_text
from ffgym.core.toml import parse_toml, toml_table
from ffgym.effects import EFFECTS, Effect, Origin, read_effects, read_origins
from ffgym.effects.reading import given_value
from ffgym.robot import RobotDescription, builtin_parameters, builtin_robots, load_draft, load_robot
from ffgym.robot.reading.load import GROUPS, draft_with_numbers, with_numbers
from ffgym.simulation.plant.machine import Climate, Machine, check_same_controller

CLIMATE_UNITS: Mapping[str, str] = MappingProxyType(
    {"ambient": "degC", "rise": "K", "time_constant": "s", "running_since": "s"}
)
"""Entries that [climate] may have."""


def load_machine(path: str | Path, known: Mapping[str, type[Effect]] = EFFECTS, *, partial: bool = False) -> Machine:
    """Read a machine file.

    Args:
        path: the file.
        known: effects that it may name.
        partial: whether entries may lack that neither the robot's description nor the file has, such as the servo: for
            what compares logs, and simulates nothing.

    Raises:
        FFGymError: if the file cannot be read, or an entry is unknown, missing or invalid.
    """
    tree = _tree(path)
    if "machine" not in tree:
        raise FFGymError(f"{path} is no machine file: it has no table [machine] with title and robot.")
    return parse_machine(tree, where=str(path), folder=Path(path).parent, known=known, partial=partial)


def known_robot(path: str | Path) -> RobotDescription:
    """Load the robot that a machine file names, without its changes: the one that the controller was made for."""
    try:
        return _robot(_tree(path).get("machine"), Path(path).parent)
    except FFGymError as error:
        raise FFGymError(f"{path}: {error}") from error


def origins_of(path: str | Path) -> tuple[Origin, ...]:
    """Read the origins of the effects of a machine file, in the order of `Machine.effects`."""
    return read_origins(_table(_tree(path), "effects"))


def robot_reference(path: str | Path) -> str | Path:
    """Read the name of the robot in a machine file: a built-in one, or the path of a description."""
    named = str(_table(_tree(path), "machine").get("robot"))
    return Path(path).parent / named if named.endswith(".toml") else named


def is_machine_file(path: str | Path) -> bool:
    """Tell if this is a readable TOML file with a table [machine]."""
    if not str(path).endswith(".toml"):
        return False
    try:
        return "machine" in _tree(path)
    except FFGymError:
        return False


def _tree(path: str | Path) -> dict[str, Any]:
    try:
        text = read_text(path)
    except FFGymError as error:
        raise FFGymError(f"Cannot read machine file {error}") from error
    return parse_toml(text, f"Cannot read machine file {path}: it")


def parse_machine(
    tree: Mapping[str, Any],
    where: str = "machine",
    folder: Path = Path(),
    known: Mapping[str, type[Effect]] = EFFECTS,
    *,
    partial: bool = False,
) -> Machine:
    """Machine of parsed tables.

    Args:
        tree: the tables.
        where: their name, for messages.
        folder: where the path of a description file starts.
        known: effects that the tables may name.
        partial: as for `load_machine`.

    Raises:
        FFGymError: if an entry is unknown, missing or invalid.
    """
    try:
        for table in tree:
            check_choice("table", table, ["machine", *GROUPS, "effects", "climate"])
        numbers = {group: tree[group] for group in GROUPS if group in tree}
        robot = _with_numbers(tree.get("machine"), folder, numbers, partial=partial)
        effects = read_effects(_table(tree, "effects"), robot, known)
        climate = parse_climate(_table(tree, "climate")) if "climate" in tree else None
        return Machine(robot=robot, effects=effects, climate=climate)
    except FFGymError as error:
        raise FFGymError(f"{where}: {error}") from error


def parse_climate(tables: Mapping[str, Any]) -> Climate:
    """Climate of the table [climate] of a file."""
    values: dict[str, Any] = {}
    for name, table in tables.items():
        unit = CLIMATE_UNITS[check_choice("entry of climate", name, list(CLIMATE_UNITS))]
        values[name] = given_value(f"climate.{name}", table, unit)
    return Climate(**values)


def climate_toml(climate: Climate, source: str) -> str:
    """Text of the table [climate] that `parse_climate` reads back to the bit."""
    entries = {
        f.name: {"value": np.asarray(getattr(climate, f.name)), "unit": CLIMATE_UNITS[f.name], "source": source}
        for f in fields(climate)
    }
    return "\n".join(toml_table("climate", entries)) + "\n"


def _table(tree: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    table = tree.get(name, {})
    if not isinstance(table, dict):
        raise FFGymError(f"[{name}] must be a table, got {table!r}.")
    return table


def _with_numbers(head: Any, folder: Path, numbers: Mapping[str, Any], *, partial: bool) -> RobotDescription:
    """The robot that a file names, with the numbers of the file."""
    named = head.get("robot") if isinstance(head, dict) else None
    draft = load_draft(folder / named) if isinstance(named, str) and named.endswith(".toml") else None
    if draft is None or not draft.missing:
        known = _robot(head, folder)
        robot = with_numbers(known, numbers) if numbers else known
    else:
        known = draft.description_for("identification")
        whole = draft_with_numbers(draft, numbers) if numbers else draft
        robot = whole.description_for("identification") if partial and whole.missing else whole.complete()
    if numbers:
        check_same_controller(robot, known)
    return robot


def _robot(head: Any, folder: Path) -> RobotDescription:
    if (
        not isinstance(head, dict)
        or set(head) != {"title", "robot"}
        or not all(isinstance(x, str) for x in head.values())
    ):
        raise FFGymError(f"[machine] must have exactly title and robot, both text, got {head!r}.")
    robot = head["robot"]
    if robot.endswith(".toml"):
        return load_robot(folder / robot)
    return load_robot(check_choice("robot of [machine]", robot, [*builtin_robots(), *builtin_parameters()]))
