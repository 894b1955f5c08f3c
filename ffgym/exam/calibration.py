"""How well a robot's numbers are known: every machine of an exam differs from its description by that much."""

from dataclasses import replace
from types import MappingProxyType

import numpy as np

from ffgym.effects import Effect
from ffgym.effects.measurement import ToolFrame
from ffgym.robot import RobotDescription
from ffgym.types import Array

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
