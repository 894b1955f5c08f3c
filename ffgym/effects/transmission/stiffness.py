"""T1: a gearbox that is stiffer or softer than described."""

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from ffgym.core.types import Array
from ffgym.effects.effect import NativeEffect
from ffgym.effects.parameters import parameter
from ffgym.robot import RobotDescription


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class JointStiffness(NativeEffect):
    """Another stiffness of the joints; their damping follows, so that the damping ratio stays."""

    name = "joint_stiffness"
    code = "T1"
    title = "joint stiffness"
    equation = r"k \to (1 + e)\, k, \quad d \to \sqrt{1 + e}\, d"
    side = "link"
    signature = "tool: proportional to the load of each joint, over its stiffness; torque: near resonance"
    way_in = "native: stiffness and damping of the deflection joint"
    confusable_with = ("G1", "T2", "T7", "T8", "T11", "X1", "X2")
    separating_motions = ("holds", "excitation")
    needs_elasticity = True

    change: Array = parameter(
        "e, more stiffness as a share of it",
        unit="1",
        low=-0.3,
        high=0.3,
        minimum=-0.9,
        source="tolerance of gearboxes' torsional stiffness, 20 to 30 %; from memory of data sheets",
        of=("drive", "joint_stiffness"),
    )

    def in_description(self, robot: RobotDescription) -> RobotDescription:
        """Return the robot with other springs and dampers in its joints."""
        drive, factor = robot.drive, 1 + self.change
        stiffer = replace(
            drive,
            joint_stiffness=drive.joint_stiffness * factor,
            joint_damping=drive.joint_damping * np.sqrt(factor),
        )
        return replace(robot, drive=stiffer)
