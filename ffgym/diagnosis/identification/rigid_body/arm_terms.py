"""Terms of the arm: they act on all motors in front of a body."""

from collections.abc import Iterator
from dataclasses import replace
from typing import ClassVar, final

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.identification.rigid_body.bodies import PARAMETERS, UNITS, bodies_of, with_bodies
from ffgym.diagnosis.identification.rigid_body.regressor import body_torque_columns
from ffgym.diagnosis.identification.rigid_body.term import Motion, Term
from ffgym.robot import RigidArm, RobotDescription


@final
class Bodies(Term):
    """Links and tool: inertia, Coriolis and centrifugal torque, gravity."""

    name: ClassVar[str] = "bodies"
    is_held: ClassVar[bool] = True

    def labels(self, robot: RobotDescription) -> tuple[str, ...]:
        """See base class."""
        return tuple(f"{body.name}.{parameter}" for body in bodies_of(robot) for parameter in PARAMETERS)

    def units(self, robot: RobotDescription) -> tuple[str, ...]:
        """See base class."""
        return UNITS * len(bodies_of(robot))

    def described(self, robot: RobotDescription) -> Array:
        """See base class."""
        return np.concatenate([body.parameters for body in bodies_of(robot)])

    def entries(self, robot: RobotDescription) -> tuple[str, ...]:
        """See base class."""
        groups = ["links"] if len(bodies_of(robot)) == robot.n_joints else ["links", "tool"]
        return tuple(f"{group}.{name}" for group in groups for name in ("mass", "com", "inertia"))

    def applied(self, robot: RobotDescription, parameters: Array) -> RobotDescription:
        """See base class."""
        return with_bodies(robot, parameters.reshape(-1, 10))

    def columns(self, robot: RobotDescription, motion: Motion) -> Iterator[Array]:
        """See base class."""
        return map(robot.drive.motor_torque, body_torque_columns(robot, motion.q, motion.dq, motion.ddq))


@final
class Springs(Term):
    """Springs between links, e.g. a counterbalance: a factor on the force of each, 1 as described."""

    name: ClassVar[str] = "springs"

    def labels(self, robot: RobotDescription) -> tuple[str, ...]:
        """See base class."""
        return tuple(f"springs.{spring.name}" for spring in robot.springs)

    def units(self, robot: RobotDescription) -> tuple[str, ...]:
        """See base class."""
        return ("1",) * len(robot.springs)

    def described(self, robot: RobotDescription) -> Array:
        """See base class."""
        return np.ones(len(robot.springs))

    def columns(self, robot: RobotDescription, motion: Motion) -> Iterator[Array]:
        """See base class."""
        for spring in robot.springs:
            arm = RigidArm(replace(robot, springs=(spring,)))
            yield robot.drive.motor_torque(arm.spring_torque(motion.q))[:, None]
