"""How much of its motors and speeds the circle test of the thesis asks of a robot."""

from dataclasses import dataclass

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.paths import SPEEDS
from ffgym.robot import RigidArm, RobotDescription
from ffgym.robot.dynamics.torques import motor_torque
from ffgym.studies.circles import circle_references


@dataclass(frozen=True, kw_only=True, eq=False)
class CircleUse:
    """Largest use along the circles at every position of the work area, without oscillation."""

    speed: float
    """Of the TCP [m/s]."""
    torque: Array | None = None
    """Share of the peak torque, shape (N,); None if the robot cannot follow."""
    joint_speed: Array | None = None
    """Share of the joint speed limits, shape (N,); None if the robot cannot follow."""
    problem: str = ""
    """Why it cannot follow."""


def circle_use(robot: RobotDescription, speed: float = SPEEDS[1]) -> CircleUse:
    """Use along the circles of the thesis at a TCP speed [m/s]; up to 40 mm/s the robot of the thesis followed."""
    arm = RigidArm(robot)
    try:
        references = circle_references(arm, None, [speed]).values()
    except FFGymError as error:
        return CircleUse(speed=speed, problem=str(error))
    torques = [np.abs(motor_torque(arm, r.q, r.dq, r.ddq).total).max(axis=0) for r in references]
    speeds = [np.abs(r.dq).max(axis=0) for r in references]
    return CircleUse(
        speed=speed,
        torque=np.max(torques, axis=0) / robot.drive.peak_torque,
        joint_speed=np.max(speeds, axis=0) / robot.kinematics.max_speed,
    )
