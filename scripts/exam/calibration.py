"""How well a robot's numbers are known: every machine of an exam differs from its description by that much."""

from dataclasses import replace
from types import MappingProxyType

import numpy as np

from ffgym.core.types import Array
from ffgym.effects import Effect
from ffgym.effects.measurement.tool_frame import ToolFrame
from ffgym.robot import RobotDescription
from ffgym.simulation.plant import Machine
from scripts.exam.hidden import Hidden

SPREAD = 0.005
"""Standard deviation of each number, as a share of it; chosen: a robot that was identified with care."""

TORQUE_OFFSET = 0.01
"""Standard deviation of the offset of current sensors, as a share of the Coulomb torque; chosen."""

TOOL_OFFSET = 15e-6
"""Standard deviation of the place of the reflector along each axis [m]; chosen: a fit of a few hundred positions."""


def miscalibrated(robot: RobotDescription, rng: np.random.Generator) -> RobotDescription:
    """A robot like `robot` whose masses, rotors, friction, stiffness and damping all are a little different."""

    def off(*shape: int) -> Array:
        return 1 + SPREAD * rng.standard_normal(shape)

    n = robot.n_joints
    drive, bodies = robot.drive, robot.bodies
    names = ("coulomb", "static", "viscous", "stribeck_velocity", "bristle_stiffness", "bristle_damping")
    friction = {name: getattr(robot.friction, name) * off(n) for name in names}
    friction["static"] = np.maximum(friction["static"], friction["coulomb"])
    return replace(
        robot,
        friction=replace(robot.friction, **friction),
        drive=replace(
            drive,
            rotor_inertia=drive.rotor_inertia * off(n),
            joint_stiffness=drive.joint_stiffness * off(n),
            joint_damping=drive.joint_damping * off(n),
        ),
        bodies=replace(bodies, mass=bodies.mass * off(n), inertia=bodies.inertia * off(n, 1)),
        quantities=MappingProxyType({}),  # origins of the numbers that were just changed
    )


def reflector_offset(robot: RobotDescription, rng: np.random.Generator) -> Effect:
    """The reflector is not quite where it is believed to be."""
    return ToolFrame.on(robot, offset=TOOL_OFFSET * rng.standard_normal(3))


def current_offset(robot: RobotDescription, rng: np.random.Generator) -> Array:
    """What current sensors show of no current, as torque, motor side [N m], shape (N,)."""
    return TORQUE_OFFSET * robot.friction.coulomb * rng.standard_normal(robot.n_joints)


def errors_beside(hidden: Hidden, described: RobotDescription, machine: Machine, offset: Array) -> dict[str, float]:
    """What errors of the description add to the numbers of an effect, by their names.

    One number of the machine is off by both, and nobody can tell them apart.

    Args:
        hidden: the effect, as large as in the log.
        described: the robot as it is told.
        machine: the one that makes the log, without the effect.
        offset: what its current sensors show of no current, as torque, motor side [N m], shape (N,).
    """
    numbers, parameters, found = hidden.numbers(described), hidden.effect.parameters(), {}
    for name, value in numbers.items():
        known = parameters.get(name)  # none for one part of a vector
        if value and known is not None and (number := known.of):
            true, told = (getattr(getattr(robot, number[0]), number[1]) for robot in (machine.robot, described))
            j = described.joints.index(hidden.joint)
            found[name] = float((true[j] / told[j] - 1) * (1 + value))
    if hidden.effect.name == "torque_offset":
        found["offset"] = -float(offset[described.joints.index(hidden.joint)])  # the current says so much more
    for other in machine.effects:
        if other.name == hidden.effect.name:  # the reflector, the only effect that all machines have
            found |= Hidden(effect=other, joint=hidden.joint).numbers(described)
    return found
