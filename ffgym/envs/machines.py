"""Machines and rigs by name, as for `plant=`, and access to workcells, which keeps their truth shut away."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ffgym.core.errors import FFGymError
from ffgym.robot import ModelOptions, RigidArm, RobotDescription, load_robot, robot_of
from ffgym.simulation.plant import Machine


def find_machine(plant: Machine | RobotDescription | str | Path) -> Machine:
    """Return the machine that is simulated.

    `plant` is a machine, a description, workcell:<name or seed>, a built-in robot, or a path that ends in .toml, to a
    machine file or a description.
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


if TYPE_CHECKING:  # loaded with the first workcell or rig
    from ffgym.simulation import Rig, Sensor
    from ffgym.workcell import Workcell

WORKCELL = "workcell:"
"""Prefix of the names of workcells."""


def is_workcell(name: str | Path) -> bool:
    """Check if a name is that of a workcell."""
    return str(name).startswith(WORKCELL)


def load_described_robot(name: str) -> RobotDescription:
    """Load a built-in robot or a description; refuse a workcell, which has none."""
    if is_workcell(name):
        raise FFGymError(
            f"{name} has no description: nothing of it is known but what it measures (ffgym simulate, ffgym record). "
            f"The nominal robot of its controller is {find_controller(name)}; give that, or another robot."
        )
    return load_robot(name)


def find_controller(name: str) -> str:
    """Return the name of the nominal robot that the controller of a machine knows; that of a robot is its own.

    `name` is that of a robot or a workcell, or a path to a description or a machine file.
    """
    from ffgym.simulation.plant.machine_file import is_machine_file, robot_reference

    if is_machine_file(name):
        return str(robot_reference(name))
    return workcell_named(name).controller if is_workcell(name) else name


def workcell_named(name: str) -> "Workcell":
    """Return the workcell workcell:<name>, or draw one for workcell:<seed> or workcell:drives-<seed>."""
    from ffgym.workcell import INSTANCES, SERIES, draw, workcell

    short = name.removeprefix(WORKCELL)
    series, _, seed = short.rpartition("-")
    if seed.isdecimal() and series in SERIES and short == f"{series}-{seed}".removeprefix("-"):
        return draw(int(seed), series)
    if short not in INSTANCES:
        names = ", ".join(f"{WORKCELL}{instance}" for instance in INSTANCES)
        raise FFGymError(
            f"Unknown workcell {name!r}. Available: {names}, or {WORKCELL}<seed> or {WORKCELL}drives-<seed> for one "
            f"drawn by a seed."
        )
    return workcell(short)


def make_rig(
    name: str | Path, *, options: ModelOptions | None = None, sensors: "Sequence[Sensor] | None" = None
) -> "Rig":
    """Make a rig by name, to run motions on.

    Args:
        name: workcell:<name or seed>; a machine file; or a built-in robot, or a path to a description: that robot, as
            its own plant.
        options: parts to leave out of a simulated robot.
        sensors: sensors of a simulated robot; none gives the exact state.

    Raises:
        FFGymError: if there is no rig of that name, or options or sensors are given for a workcell.
    """
    from ffgym.simulation import SimulatedRig
    from ffgym.simulation.plant import load_machine
    from ffgym.simulation.plant.machine_file import is_machine_file, known_robot

    if not is_workcell(name) and is_machine_file(name):
        arm, machine = RigidArm(known_robot(name)), load_machine(name)
        return SimulatedRig(arm=arm, machine=machine, options=options, sensors=sensors or (), name=Path(name).stem)
    if not is_workcell(name):
        return SimulatedRig(arm=RigidArm(load_robot(name)), options=options, sensors=sensors or ())
    if options is not None or sensors is not None:
        raise FFGymError(f"{name} has fixed parameters and sensors. Leave options and sensors out, or choose a robot.")
    return workcell_named(str(name))
