"""A part of the motor torque that is linear in its parameters: what a fit is built from."""

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ffgym.core.types import Array
from ffgym.robot import RobotDescription

ABOVE_ZERO = 1e-3
"""Smallest share of its size that a parameter may have that a description must give above 0."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Motion:
    """Motion of an arm and its motors at instants, T rows and N joints."""

    q: Array
    """Positions of the links, link side [rad or m], shape (T, N)."""
    dq: Array
    ddq: Array
    motor_dq: Array
    """Motor speed [rad/s], shape (T, N)."""
    motor_ddq: Array
    """Motor acceleration [rad/s^2], shape (T, N)."""


class Term(ABC):
    """A part of the motor torque that is linear in K parameters."""

    name: ClassVar[str]
    """For settings and files."""
    is_held: ClassVar[bool] = False
    """Whether the fit is held near the description; friction is not, since nobody knows it before it is measured."""
    least: ClassVar[float] = -np.inf
    """Smallest value, as a share of the parameter's size: of its description, or of the torque that its motor has."""

    @abstractmethod
    def labels(self, robot: RobotDescription) -> tuple[str, ...]:
        """Name of each parameter, K of them."""

    @abstractmethod
    def units(self, robot: RobotDescription) -> tuple[str, ...]:
        """Unit of each parameter."""

    @abstractmethod
    def described(self, robot: RobotDescription) -> Array:
        """What the description says of each parameter, 0 where it knows no such thing, shape (K,)."""

    def entries(self, robot: RobotDescription) -> tuple[str, ...]:
        """Entries of a description that hold its parameters; none if no description does."""
        return ()

    def applied(self, robot: RobotDescription, parameters: Array) -> RobotDescription:
        """The robot with `parameters` (K,) in those entries."""
        return robot

    @abstractmethod
    def columns(self, robot: RobotDescription, motion: Motion) -> Iterator[Array]:
        """Motor torque of each parameter at 1, motor side [N m], shapes (T, k, N), a few parameters at a time."""

    def torque(self, robot: RobotDescription, motion: Motion, parameters: Array) -> Array:
        """Motor torque of `parameters` (K,), motor side [N m], shape (T, N)."""
        total, start = np.zeros_like(motion.motor_dq), 0
        for columns in self.columns(robot, motion):
            stop = start + columns.shape[1]
            total += np.einsum("tkn,k->tn", columns, parameters[start:stop])
            start = stop
        return total


class MotorTerm(Term):
    """A term with one parameter for each motor, which acts on no other motor."""

    unit: ClassVar[str]
    """Of the parameter, motor side."""

    def labels(self, robot: RobotDescription) -> tuple[str, ...]:
        """See base class."""
        return tuple(f"{self.name}.{joint}" for joint in robot.joints)

    def units(self, robot: RobotDescription) -> tuple[str, ...]:
        """See base class."""
        return (self.unit,) * robot.n_joints

    def described(self, robot: RobotDescription) -> Array:
        """See base class."""
        return np.zeros(robot.n_joints)

    def columns(self, robot: RobotDescription, motion: Motion) -> Iterator[Array]:
        """See base class."""
        own = self.of_motor(motion)
        columns = np.zeros((len(own), robot.n_joints, robot.n_joints))
        motors = np.arange(robot.n_joints)
        columns[:, motors, motors] = own
        yield columns

    @abstractmethod
    def of_motor(self, motion: Motion) -> Array:
        """Torque on each motor of its parameter at 1 [N m], shape (T, N)."""
