"""What `plant=` may be: a machine, a description, or the name of either."""

from pathlib import Path

from ffgym.plant import Machine
from ffgym.robot import RobotDescription, robot_of


def machine_of(plant: Machine | RobotDescription | str | Path) -> Machine:
    """Return the machine that is simulated.

    Args:
        plant: a machine, a description, a built-in name, or a path to a description that ends in .toml.

    Raises:
        FFGymError: if it is none of these.
    """
    return plant if isinstance(plant, Machine) else Machine.of(robot_of(plant, "plant"))
