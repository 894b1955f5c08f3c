"""Robots of commands that need a description: of what only measures, there is none."""

from ffgym.core.errors import FFGymError
from ffgym.envs.machines import is_workcell
from ffgym.envs.workcell_circles import CONTROLLER
from ffgym.robot import RobotDescription, load_robot


def described_robot(name: str) -> RobotDescription:
    """A built-in robot, or that of a description's path.

    Raises:
        FFGymError: if there is none of that name, or it is a workcell or a machine file.
    """
    if is_workcell(name):
        raise FFGymError(
            f"{name} has no description: nothing of it is known but what it measures (ffgym simulate, ffgym record). "
            f"What its controller knows is {CONTROLLER}; give that, or another robot."
        )
    return load_robot(name)
