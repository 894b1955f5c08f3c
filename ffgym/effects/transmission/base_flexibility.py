"""T7: a base that gives way."""

from dataclasses import dataclass
from typing import final

import mujoco
import numpy as np

from ffgym.core.types import Array
from ffgym.effects.parameters import parameter
from ffgym.effects.transmission.flexible_structure import FlexibleStructure
from ffgym.robot import RobotDescription

RADIUS = 0.3
"""Radius of gyration of the base [m], which descriptions leave out as it stands still; chosen: half of its width. The
arm on top has some hundred times its inertia about the floor."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class BaseFlexibility(FlexibleStructure):
    """The base tilts and turns on its floor, as a spring with some damping about each axis of the world."""

    name = "base_flexibility"
    code = "T7"
    title = "flexibility of the base"
    equation = r"\phi_i = c_i\, (\tau_i - (t_d / c_i)\, \dot\phi_i), \quad i = x, y, z"
    signature = "tool: off the axes of the joints, and at a frequency that torque hardly shows"
    way_in = "joints of the base in the MuJoCo model, about those axes whose compliance is not 0"
    confusable_with = ("T1", "T8", "T11", "X2")

    compliance: Array = parameter(
        "c, angle over torque about the axes of the base",
        unit="rad/(N m)",
        low=0.0,
        high=3e-7,
        minimum=0.0,
        per="vector",
        source="first mode of 5 to 15 Hz with load, from memory of the literature; here some 1000 kg m^2 on it",
    )

    def in_model(self, spec: mujoco.MjSpec, robot: RobotDescription) -> None:
        """Give the base one spring-damper hinge per compliant axis."""
        base = spec.body("base")
        if np.any(self.compliance):
            base.mass = max(robot.base_mass, 1.0)  # what moves must weigh something
            base.fullinertia = base.mass * RADIUS**2 * np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
        for i, name in enumerate("xyz"):
            if self.compliance[i] > 0:
                base.add_joint(name=f"base_{name}", axis=np.eye(3)[i], **self.joint(i))
