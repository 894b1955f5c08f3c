"""Terms of single motors: rotors, friction, offsets."""

from dataclasses import replace
from typing import ClassVar, final

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.identification.rigid_body.term import ABOVE_ZERO, Motion, MotorTerm
from ffgym.robot import RobotDescription


@final
class RotorInertia(MotorTerm):
    """Motor and gear input: J times motor acceleration."""

    name: ClassVar[str] = "rotor_inertia"
    is_held: ClassVar[bool] = True
    least: ClassVar[float] = ABOVE_ZERO
    unit: ClassVar[str] = "kg m^2"

    def described(self, robot: RobotDescription) -> Array:
        """See base class."""
        return robot.drive.rotor_inertia

    def entries(self, robot: RobotDescription) -> tuple[str, ...]:
        """See base class."""
        return ("drive.rotor_inertia",)

    def applied(self, robot: RobotDescription, parameters: Array) -> RobotDescription:
        """See base class."""
        return replace(robot, drive=replace(robot.drive, rotor_inertia=parameters))

    def of_motor(self, motion: Motion) -> Array:
        """See base class."""
        return motion.motor_ddq


@final
class Coulomb(MotorTerm):
    """Coulomb friction: its sign is that of the motor speed."""

    name: ClassVar[str] = "coulomb"
    least: ClassVar[float] = ABOVE_ZERO
    unit: ClassVar[str] = "N m"

    def described(self, robot: RobotDescription) -> Array:
        """See base class."""
        return robot.friction.coulomb

    def entries(self, robot: RobotDescription) -> tuple[str, ...]:
        """See base class; the breakaway torque goes along, since it cannot be below."""
        return ("friction.coulomb", "friction.static")

    def applied(self, robot: RobotDescription, parameters: Array) -> RobotDescription:
        """See base class; the breakaway torque keeps its ratio to the Coulomb torque."""
        friction = robot.friction
        static = np.maximum(friction.static * (parameters / friction.coulomb), parameters)
        return replace(robot, friction=replace(friction, coulomb=parameters, static=static))

    def of_motor(self, motion: Motion) -> Array:
        """See base class."""
        return np.sign(motion.motor_dq)


@final
class Viscous(MotorTerm):
    """Viscous friction: proportional to motor speed."""

    name: ClassVar[str] = "viscous"
    least: ClassVar[float] = 0.0
    unit: ClassVar[str] = "N m s/rad"

    def described(self, robot: RobotDescription) -> Array:
        """See base class."""
        return robot.friction.viscous

    def entries(self, robot: RobotDescription) -> tuple[str, ...]:
        """See base class."""
        return ("friction.viscous",)

    def applied(self, robot: RobotDescription, parameters: Array) -> RobotDescription:
        """See base class."""
        return replace(robot, friction=replace(robot.friction, viscous=parameters))

    def of_motor(self, motion: Motion) -> Array:
        """See base class."""
        return motion.motor_dq


@final
class Offset(MotorTerm):
    """A constant: an offset of the torque signal, or half the difference of Coulomb friction in both directions."""

    name: ClassVar[str] = "offset"
    unit: ClassVar[str] = "N m"

    def of_motor(self, motion: Motion) -> Array:
        """See base class."""
        return np.ones_like(motion.motor_dq)


@final
class ViscousAsymmetry(MotorTerm):
    """Half the difference of viscous friction in both directions, times the absolute motor speed."""

    name: ClassVar[str] = "viscous_asymmetry"
    unit: ClassVar[str] = "N m s/rad"

    def of_motor(self, motion: Motion) -> Array:
        """See base class."""
        return np.abs(motion.motor_dq)
