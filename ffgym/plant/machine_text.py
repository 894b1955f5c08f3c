"""Machines as machine files: what `load_machine` reads back to the bit."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from ffgym.effects import effects_toml
from ffgym.errors import FFGymError
from ffgym.files import write_text
from ffgym.plant.machine import Machine
from ffgym.plant.machine_file import climate_toml
from ffgym.robot import RobotDescription, builtin_robots, load_robot
from ffgym.robot.reading.parameters import GROUPS
from ffgym.robot.reading.rule import JointFrame, si_units
from ffgym.robot.reading.rules import RULES


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
    text = machine_text(machine, title=title, source=source)
    write_text(Path(path), text)
    return Path(path)


def machine_text(machine: Machine, *, title: str, source: str) -> str:
    """Text of a machine file; arguments as for `save_machine`.

    Raises:
        FFGymError: if the robot cannot be said in a machine file.
    """
    name = machine.robot.name
    if name not in builtin_robots():
        raise FFGymError(
            f"Robot {name!r} is not built in; write the machine file by hand, with the path of its description."
        )
    parts = [f"[machine]\ntitle = {json.dumps(title)}\nrobot = {json.dumps(name)}\n"]
    parts += _numbers(machine.robot, load_robot(name), source)
    parts.append(effects_toml(machine.effects, source))
    if machine.climate is not None:
        parts.append(climate_toml(machine.climate, source))
    return "\n".join(part for part in parts if part)


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
        unit: Any = units[0] if len(units) == 1 else list(units)
        side = f"side = {json.dumps(rule.side)}\n" if rule.side else ""
        tables.append(
            f"[{path}]\nvalue = {np.asarray(mine).tolist()}\nunit = {json.dumps(unit)}\n{side}"
            f'origin = "derived"\nsource = {json.dumps(source)}\n'
        )
    return tables
