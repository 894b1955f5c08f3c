"""Whether two robots can have one controller."""

from dataclasses import fields
from typing import Any

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.robot import RobotDescription


def check_same_controller(own: RobotDescription, other: RobotDescription) -> None:
    """Check that a plant fits the controller of a robot.

    Raises:
        FFGymError: if they differ in what a controller knows, or in the make of their joints, springs and tool.
    """
    pairs: dict[str, tuple[Any, Any]] = {
        "joints": (own.joints, other.joints),
        "drive.gear_ratio": (own.drive.gear_ratio, other.drive.gear_ratio),
        "drive.coupling": (own.drive.matrix, other.drive.matrix),
        "kinematics.types": (own.kinematics.types, other.kinematics.types),
        "bodies of springs": ([spring.bodies for spring in own.springs], [spring.bodies for spring in other.springs]),
        "having a tool": (own.tool is not None, other.tool is not None),
        "simulation.physics_dt": (own.physics_dt, other.physics_dt),
    }
    pairs |= {f"servo.{f.name}": (getattr(own.servo, f.name), getattr(other.servo, f.name)) for f in fields(own.servo)}
    for name, (mine, theirs) in pairs.items():
        if not np.array_equal(mine, theirs):
            raise FFGymError(
                f"Robots {own.name!r} and {other.name!r} differ in {name}, {mine} and {theirs}; a plant must have what "
                f"its controller was made for."
            )
