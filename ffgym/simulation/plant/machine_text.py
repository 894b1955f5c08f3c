"""Text of machine files, which `load_machine` reads back to the bit."""

import os
import tomllib
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.files import write_text
from ffgym.core.toml import single, toml_table
from ffgym.effects import Origin, effects_toml
from ffgym.robot import ModelOptions, RobotDescription, builtin_robots, load_draft, load_robot
from ffgym.robot.reading.load import GROUPS
from ffgym.robot.reading.quantity import si_units
from ffgym.robot.reading.rules import RULES
from ffgym.simulation.plant.machine import Machine, check_same_controller
from ffgym.simulation.plant.machine_file import climate_toml, parse_machine


def save_machine(
    machine: Machine,
    path: str | Path,
    *,
    title: str,
    source: str,
    robot: str | Path | None = None,
    origins: Sequence[Origin] = (),
) -> Path:
    """Write a machine file.

    Args:
        machine: what to write; its robot differs from the one that is named in what a parameter file can say.
        path: ends in .toml.
        title: a line for people.
        source: where its numbers come from.
        robot: name of a built-in robot or of its parameters, or path of a description; None is the robot's own name.
        origins: more about the numbers of the first effects.

    Raises:
        FFGymError: if the robot cannot be said in a machine file, or the file cannot be written.
    """
    place = Path(path)
    if place.suffix != ".toml":
        raise FFGymError(f"A machine file ends in .toml, got {path}.")
    written = machine_text(machine, title=title, source=source, robot=robot, origins=origins, folder=place.parent)
    write_text(place, written)
    return place


def machine_text(
    machine: Machine,
    *,
    title: str,
    source: str,
    robot: str | Path | None = None,
    origins: Sequence[Origin] = (),
    folder: Path = Path(),
) -> str:
    """Text of a machine file for `folder`; other arguments as for `save_machine`."""
    machine = Machine.of(machine)
    known, named = _name_effects(machine.robot, robot, folder)
    parts = ["\n".join(toml_table("machine", {"title": str(title), "robot": named})) + "\n"]
    parts += _numbers(machine.robot, known, source)
    parts.append(effects_toml(machine.effects, source, origins))
    if machine.climate is not None:
        parts.append(climate_toml(machine.climate, source))
    written = "\n".join(part for part in parts if part)
    _check_says(written, machine, folder)
    return written


def _name_effects(robot: RobotDescription, reference: str | Path | None, folder: Path) -> tuple[RobotDescription, str]:
    """The robot that a file in `folder` names, and how."""
    if reference is None:
        if robot.name not in builtin_robots():
            raise FFGymError(f"Robot {robot.name!r} is not built in; say which file describes it: robot=PATH.")
        reference = robot.name
    if not str(reference).endswith(".toml"):
        return load_robot(reference), str(reference)
    path = Path(os.path.realpath(reference))
    draft = load_draft(path)
    known = draft.description_for("identification") if draft.missing else load_robot(path)
    try:
        return known, Path(os.path.relpath(path, folder.resolve())).as_posix()
    except ValueError:  # another drive
        return known, path.as_posix()


def _check_says(written: str, machine: Machine, folder: Path) -> None:
    """Check that a machine file leaves nothing out."""
    options = ModelOptions(looks=False)
    read = parse_machine(tomllib.loads(written), folder=folder, partial=True)
    check_same_controller(machine.robot, read.robot)
    if read.physics(options) != machine.physics(options):
        raise FFGymError(
            f"Robot {machine.robot.name!r} and the robot that the file names differ in geometry, which a machine file "
            f"cannot hold. Write a description of it, and name that."
        )


def _numbers(robot: RobotDescription, known: RobotDescription, source: str) -> list[str]:
    """Tables of all numbers in which the robot differs from the known one, or that this lacks; files' keep sources."""
    tables = []
    for path, rule in RULES.items():
        group, _, name = path.partition(".")
        if group not in GROUPS:
            continue
        mine, theirs = (getattr(getattr(r, GROUPS[group]), name, None) for r in (robot, known))
        if rule.neutral is not None and (mine is None) != (theirs is None):  # what one of both leaves out
            absent = np.full(robot.n_joints, rule.neutral)
            mine, theirs = absent if mine is None else mine, absent if theirs is None else theirs
        lacking = not rule.optional and path not in known.quantities
        if mine is None or theirs is None or (np.array_equal(mine, theirs) and not lacking):
            continue
        given = robot.quantities.get(path)
        said = given.source if given is not None and np.array_equal(given.value, mine) else source
        unit = single(si_units(rule, rule.side, robot.kinematics.types))
        entries = {"value": np.asarray(mine), "unit": unit, "side": rule.side, "origin": "derived", "source": said}
        tables.append("\n".join(toml_table(path, entries)) + "\n")
    return tables
