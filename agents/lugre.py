"""LuGre friction compensation: the torque that the friction model gives at the speed of the reference.

Idea and source: thesis 4.1 (static) and 4.2 (dynamic), after Canudas de Wit et al. (1995). Friction is computed from
the reference, not from the measured speed, so that no noise enters and the torque comes in time.

Run it:

    ffgym demo --agents none lugre_static lugre_dynamic

Parameters come from a robot description, or from any file that has its `[friction.*]` tables.

Logged: nothing; the laws learn nothing. Departures from the source: the bristles are integrated exactly unless
`discretisation="euler"` selects the 40 Euler steps of the thesis (4.6); the added torque starts at zero.
"""

from pathlib import Path

from ffgym.agents.declaration import AgentEntry, declare
from ffgym.control import DynamicLuGre, DynamicLuGreEuler, DynamicLuGreExact, LawStyle, StaticLuGre
from ffgym.core.errors import check_choice
from ffgym.robot import RobotDescription, robot_of
from ffgym.robot.friction import LuGreParameters

DISCRETISATIONS = {"exact": DynamicLuGreExact, "euler": DynamicLuGreEuler}
"""Integration methods of the bristles of the dynamic model, by name."""


def static_lugre(parameters: LuGreParameters | RobotDescription | str | Path) -> StaticLuGre:
    """Make static LuGre, thesis (4.1), with the friction of a robot: a description, a name, or a file.

    Raises:
        FFGymError: if the file cannot be read or is wrong.
    """
    return StaticLuGre(find_friction(parameters))


def dynamic_lugre(
    parameters: LuGreParameters | RobotDescription | str | Path, discretisation: str = "exact"
) -> DynamicLuGre:
    """Make dynamic LuGre, thesis (4.3), with the friction of a robot: a description, a name, or a file.

    Raises:
        FFGymError: if the file cannot be read or is wrong, or the discretisation is unknown.
    """
    law = DISCRETISATIONS[check_choice("discretisation", discretisation, list(DISCRETISATIONS))]
    return law(find_friction(parameters))


def find_friction(parameters: LuGreParameters | RobotDescription | str | Path) -> LuGreParameters:
    """Return friction parameters as given, or those of a description, a built-in robot, or a file."""
    if isinstance(parameters, LuGreParameters):
        return parameters
    return robot_of(parameters, "friction parameters").friction


declare(
    AgentEntry(
        name="lugre_static",
        title="static LuGre",
        about="Friction of the static LuGre model at the speed of the reference, nominal parameters.",
        track="causal, nominal parameters",
        order=2,
        page="lugre.md",
        style=LawStyle(label="static LuGre", colour="#D55E00", marker="s"),
        make=lambda setting: static_lugre(setting.robot),
    ),
    AgentEntry(
        name="lugre_dynamic",
        title="dynamic LuGre",
        about="Friction of the dynamic LuGre model along the reference, nominal parameters.",
        track="causal, nominal parameters",
        order=3,
        page="lugre.md",
        style=LawStyle(label="dynamic LuGre", colour="#009E73", marker="^"),
        make=lambda setting: dynamic_lugre(setting.robot),
    ),
)
