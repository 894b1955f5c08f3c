"""What `plant=` may be: a machine, a description, or the name of either."""

from pathlib import Path

from ffgym.core.errors import FFGymError
from ffgym.envs.rigs import is_workcell, workcell_named
from ffgym.robot import RobotDescription, robot_of
from ffgym.simulation.plant import Machine


def machine_of(plant: Machine | RobotDescription | str | Path) -> Machine:
    """Return the machine that is simulated.

    Args:
        plant: a machine, a description, workcell:<name or seed>, a built-in robot, or a path that ends in .toml, to a
            machine file or a description.

    Raises:
        FFGymError: if it is none of these.
    """
    if isinstance(plant, Machine):
        return plant
    if isinstance(plant, str) and is_workcell(plant):
        return workcell_named(plant).machine
    if isinstance(plant, str | Path) and str(plant).endswith(".toml"):
        from ffgym.simulation.plant.machine_file import is_machine_file, load_machine

        if is_machine_file(plant):
            return load_machine(plant)
    if not isinstance(plant, str | Path | RobotDescription):
        raise FFGymError(
            f"plant = {plant!r} must be a Machine, a RobotDescription, the name of a built-in robot, workcell:<name or "
            f"seed>, or a path that ends in .toml."
        )
    return Machine.of(robot_of(plant, "plant"))
