"""Base laws below a residual policy, each made from the nominal model of the robot."""

import tomllib
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType

from ffgym.agents.elastic import elastic_law
from ffgym.agents.lugre import dynamic_lugre, static_lugre
from ffgym.agents.model import model_law
from ffgym.control import CausalLaw
from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.files import read_text
from ffgym.robot import RigidArm, RobotDescription
from ffgym.simulation.plant.machine_file import parse_machine

MODEL = "model"
"""Base that needs the text of a machine file beside the robot."""

_MADE: Mapping[str, Callable[[RobotDescription], CausalLaw | None]] = MappingProxyType(
    {
        "none": lambda robot: None,
        "lugre_static": static_lugre,
        "lugre_dynamic": dynamic_lugre,
        "elastic": lambda robot: elastic_law(RigidArm(robot)),
    }
)

BASES = (*_MADE, MODEL)
"""Names of all bases, as in `ffgym.agents.catalogue`."""

ACTION_SCALES: Mapping[str, float] = MappingProxyType(
    {"none": 30.0, "lugre_static": 30.0, "lugre_dynamic": 30.0, "elastic": 110.0, MODEL: 110.0}
)
"""Torque of an action of 1 in breakaway torques. Chosen: room for the base's torque at 100 mm/s with the built-in
robot and a residual on top; laws that bend springs need far more than friction."""


def base_named(base: str) -> tuple[str, str | None]:
    """Split a base as in 'elastic' or 'model:machine.toml' into its name and the text of its machine file.

    Raises:
        FFGymError: if there is no such base, or its file cannot be read.
    """
    name, colon, file = base.partition(":")
    check_choice("base", name, BASES)
    if name != MODEL:
        if colon:
            raise FFGymError(f"Base {name!r} takes no file, got {base!r}; {MODEL}:FILE does.")
        return name, None
    if not file:
        raise FFGymError(f"Base {MODEL!r} needs a machine file: {MODEL}:machine.toml. Without one it is 'elastic'.")
    text = read_text(Path(file))
    _check_whole(text, file)
    return name, text


def base_law(name: str, machine: str | None, robot: RobotDescription) -> CausalLaw | None:
    """Make the law for a robot; None adds nothing.

    Args:
        name: one of BASES.
        machine: text of a machine file, for `model` alone.
        robot: nominal description, on which the controller relies.

    Raises:
        FFGymError: if there is no such base, or it cannot be made for the robot.
    """
    check_choice("base", name, BASES)
    if (machine is not None) != (name == MODEL):
        raise FFGymError(f"Base {name!r} {'needs' if name == MODEL else 'takes no'} text of a machine file.")
    if machine is None:
        return _MADE[name](robot)
    believed = parse_machine(_check_whole(machine, "machine of the policy"), where="machine of the policy")
    return model_law(believed, RigidArm(robot), name=MODEL)


def _check_whole(text: str, where: str) -> dict[str, object]:
    """Check that a machine file needs no other file, and return its tables."""
    try:
        tree = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise FFGymError(f"{where}: it is not valid TOML: {error}.") from error
    head = tree.get("machine")
    if not isinstance(head, dict) or not isinstance(head.get("robot"), str):
        raise FFGymError(f"{where} is no machine file: it has no table [machine] with title and robot.")
    if head["robot"].endswith(".toml"):
        raise FFGymError(
            f"{where}: names its robot by a path, {head['robot']!r}, which a policy cannot keep; a machine file of a "
            f"policy must name a built-in robot."
        )
    return tree
