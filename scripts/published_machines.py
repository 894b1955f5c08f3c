"""Write the machines of the structures that explain the published robot, from docs/published_robot.json.

    python -m scripts.published_machines

`irb4600_60_205_arm_losses` is a parameter file of the package: the built-in robot, refitted with friction behind the
elasticity. `docs/backlash.toml` is a machine file: the robot refitted with backlash.
"""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import tomlkit
import tyro

from ffgym.core.files import read_text, write_text
from ffgym.robot import RobotDescription, load_robot
from ffgym.robot.reading.load import ENTRIES
from ffgym.robot.reading.quantity import si_units
from ffgym.robot.reading.rules import RULES
from ffgym.simulation.plant import save_machine
from scripts.tables.page import DOCS
from scripts.tables.published_robot import RESULT, fitted_machine, structure_candidate

SOURCE = (
    "ffgym diagnose --table thesis, structure {}: path errors of the published robot with no, static LuGre and dynamic "
    "LuGre compensation at 10 and 40 mm/s (docs/published_robot.json)"
)
PARAMETERS = Path("ffgym/robot/parameters/irb4600_60_205_arm_losses.toml")
_DIGITS = 4


@dataclass(frozen=True)
class Config:
    """Machines of the published robot's structures."""

    result: Path = RESULT
    """Result of the diagnosis from the table."""
    parameters: Path = PARAMETERS
    """Parameter file with friction behind the elasticity."""
    backlash: Path = DOCS / "backlash.toml"
    """Machine file with backlash."""


def main(config: Config) -> None:
    """Write both files."""
    result = json.loads(read_text(config.result))
    robot = load_robot(result["table"]["robot"])
    fits = {each["name"]: each for each in result["structures"]}
    write_parameters(config.parameters, robot, fitted_machine(robot, fits["arm_friction"]).robot)
    machine = structure_candidate(robot, fits["backlash"]).machine
    title = "the built-in robot refitted to the published path errors with backlash in joints 1 to 3"
    save_machine(machine, config.backlash, title=title, source=SOURCE.format("backlash"), robot=robot.name)


def write_parameters(path: Path, before: RobotDescription, after: RobotDescription) -> None:
    """Write the numbers that a fit has changed as a parameter file, with origin and the values before it."""
    document: dict[str, Any] = {
        "parameters": {
            "robot": before.name,
            "title": "refitted to the published path errors with friction behind the elasticity of joints 1 to 3",
        }
    }
    for entry in sorted(ENTRIES):
        group, _, name = entry.partition(".")
        part = {"links": "bodies"}.get(group, group)
        if getattr(after, part) is getattr(before, part):
            continue
        old, new = (getattr(getattr(robot, part), name) for robot in (before, after))
        if new is None or np.array_equal(old, new):
            continue
        document.setdefault(group, {})[name] = _table(before, entry, old, np.asarray(new))
    head = "# Written by scripts/published_machines.py from docs/published_robot.json.\n\n"
    write_text(path, head + tomlkit.dumps(document))


def _table(before: RobotDescription, entry: str, old: Any, new: Any) -> dict[str, Any]:
    """Table of one entry: joints that the fit has changed are fitted, others keep their origin."""
    rule, known = RULES[entry], before.quantities.get(entry)
    were = np.zeros_like(new) if old is None else np.asarray(old)
    origins = ("chosen",) * len(new) if known is None else known.origin * (1 if len(known.origin) > 1 else len(new))
    moved = were != new
    kept = ["derived" if origin == "fitted" else origin for origin in origins]
    return {
        "value": _round(new),
        "unit": si_units(rule, rule.side, before.kinematics.types)[0],
        "side": rule.side,
        "origin": ["fitted" if here else origin for here, origin in zip(moved, kept, strict=True)],
        "source": SOURCE.format("arm_friction"),
        "prior": _round(were),
        "prior_source": "no friction behind the elasticity"
        if known is None
        else f"the nominal robot's: {known.source}",
    }


def _round(values: Any) -> list[float]:
    return [float(f"{value:.{_DIGITS}g}") for value in values]


if __name__ == "__main__":
    main(tyro.cli(Config))
