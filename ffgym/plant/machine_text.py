"""Machines as machine files: what `load_machine` reads back to the bit."""

import tomllib
from pathlib import Path

import numpy as np

from ffgym.effects import effects_toml
from ffgym.errors import FFGymError
from ffgym.files import write_text
from ffgym.plant.machine import Machine
from ffgym.plant.machine_file import climate_toml, parse_machine
from ffgym.plant.sameness import check_same_controller
from ffgym.robot import ModelOptions, RobotDescription, builtin_robots, load_robot
from ffgym.robot.reading.parameters import GROUPS
from ffgym.robot.reading.rule import JointFrame, si_units
from ffgym.robot.reading.rules import RULES
from ffgym.robot.template.toml_text import names, text


def save_machine(machine: Machine, path: str | Path, *, title: str, source: str) -> Path:
    """Write a machine file.

    Args:
        machine: what to write; its robot is a built-in one, or differs from it in what a parameter file can say.
        path: ends in .toml.
        title: a line for people.
        source: where its numbers come from.

    Raises:
        FFGymError: if the robot cannot be said in a machine file, or the file cannot be written.
    """
    if Path(path).suffix != ".toml":
        raise FFGymError(f"A machine file ends in .toml, got {path}.")
    write_text(Path(path), machine_text(machine, title=title, source=source))
    return Path(path)


def machine_text(machine: Machine, *, title: str, source: str) -> str:
    """Text of a machine file; arguments as for `save_machine`.

    Raises:
        FFGymError: if the robot cannot be said in a machine file.
    """
    machine = Machine.of(machine)
    name = machine.robot.name
    if name not in builtin_robots():
        raise FFGymError(
            f"Robot {name!r} is not built in; write the machine file by hand, with the path of its description."
        )
    parts = [f"[machine]\ntitle = {text(str(title))}\nrobot = {text(name)}\n"]
    parts += _numbers(machine.robot, load_robot(name), source)
    parts.append(effects_toml(machine.effects, source))
    if machine.climate is not None:
        parts.append(climate_toml(machine.climate, source))
    written = "\n".join(part for part in parts if part)
    _check_says(written, machine)
    return written


def _check_says(written: str, machine: Machine) -> None:
    """Check that a machine file leaves nothing out."""
    options = ModelOptions(looks=False)
    read = parse_machine(tomllib.loads(written))
    check_same_controller(machine.robot, read.robot)
    if read.physics(options) != machine.physics(options):
        raise FFGymError(
            f"Robot {machine.robot.name!r} differs from the built-in one in what a machine file cannot say (geometry); "
            f"write a description of it, and a machine file beside it that names it."
        )


def _numbers(robot: RobotDescription, known: RobotDescription, source: str) -> list[str]:
    """Tables of all numbers in which the robot differs from the built-in one."""
    joints = JointFrame(types=robot.kinematics.types, gear_ratio=robot.drive.gear_ratio)
    tables = []
    for path, rule in RULES.items():
        group, _, name = path.partition(".")
        if group not in GROUPS:
            continue
        mine, theirs = (getattr(getattr(r, GROUPS[group]), name, None) for r in (robot, known))
        if mine is None or theirs is None or np.array_equal(mine, theirs):
            continue
        units = si_units(rule, rule.side, joints)
        unit = text(units[0]) if len(units) == 1 else names(units)
        side = f"side = {text(rule.side)}\n" if rule.side else ""
        tables.append(
            f"[{path}]\nvalue = {np.asarray(mine).tolist()}\nunit = {unit}\n{side}"
            f'origin = "derived"\nsource = {text(source)}\n'
        )
    return tables
