"""Options that say nothing about a robot are refused, not ignored."""

from collections.abc import Sequence
from dataclasses import fields
from typing import Any

from ffgym.core.errors import FFGymError
from ffgym.robot import RobotDescription


def given_options(command: Any, names: Sequence[str]) -> list[str]:
    """Those of the options `names` of a command that have another value than their default, as they are typed."""
    defaults = {field.name: field.default for field in fields(command)}
    return ["--" + name.replace("_", "-") for name in names if getattr(command, name) != defaults[name]]


def refuse_unused(command: Any, robot: RobotDescription) -> None:
    """Raise if a command got options of circles for a robot that runs sines, or the other way round.

    Raises:
        FFGymError: if an option has another value than its default, and no effect.
    """
    given = given_options(command, ("positions", "speeds_mm_s") if robot.work_area is None else ("frequencies_hz",))
    if given:
        motion = "sines, having no work area" if robot.work_area is None else "circles in its work area"
        raise FFGymError(f"{', '.join(given)} has no effect: robot {robot.name!r} runs {motion}. Leave it out.")
