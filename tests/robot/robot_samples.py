"""Robots with what the built-in ones lack."""

from dataclasses import replace

import numpy as np

from ffgym.robot import RobotDescription
from ffgym.robot.parts import Spring


def unusual(robot: RobotDescription) -> RobotDescription:
    """Copy of the six-axis robot on a rail, with a motor that turns backwards, coupled wrist and counterbalance."""
    axis, limits = robot.kinematics.axis.copy(), robot.kinematics.range.copy()
    axis[0], limits[0] = [1.0, 0.0, 0.0], [-2.0, 2.0]
    kinematics = replace(robot.kinematics, axis=axis, range=limits, types=("slide", *["hinge"] * 5))
    ratio, coupling = robot.drive.gear_ratio.copy(), np.zeros((6, 6))
    ratio[2] *= -1
    coupling[4, 3], coupling[5, 3], coupling[5, 4] = 1.0, -1.0, 1.0 / 3.0
    balance = Spring(
        name="balance",
        bodies=("frame", "lower_arm"),
        start=np.array([-0.2, 0.0, 0.1]),
        end=np.array([-0.2, 0.0, 0.3]),
        length=0.15,
        stiffness=(2e4, 1e3, 100.0 / 3.0),
    )
    drive = replace(robot.drive, gear_ratio=ratio, coupling=coupling)
    return replace(robot, name="unusual", kinematics=kinematics, drive=drive, springs=(balance,))
