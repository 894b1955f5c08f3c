"""G1: a load that the controller does not know."""

from dataclasses import dataclass
from typing import final

from ffgym.core.types import Array
from ffgym.effects.effect import NativeEffect
from ffgym.effects.parameters import parameter
from ffgym.robot import RobotDescription
from ffgym.robot.description import with_payload


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Payload(NativeEffect):
    """A body at the tool, beside the tool itself."""

    name = "payload"
    code = "G1"
    title = "payload"
    equation = r"\tau \mathrel{+}= J^T m\, (\ddot r_c - g) + J_\omega^T m \rho^2 \dot\omega"
    side = "tool"
    signature = "torque: on several joints at once, in the ratio of the columns of the Jacobian, at rest too"
    way_in = "native: mass, centre of mass and inertia of the tool"
    confusable_with = ("F6", "G2", "T1", "T6")
    separating_motions = ("holds", "slow_triangles", "excitation")
    needs_tool = True
    patterns = (("function", "load"),)

    mass: Array = parameter(
        "m", unit="kg", low=0.0, high=60.0, minimum=0.0, per="machine", source="robots for 10 to 250 kg; here 60 kg"
    )
    offset: Array = parameter(
        "centre of mass from the TCP, in the axes of tool0",
        role="span",
        unit="m",
        null=None,
        low=-0.2,
        high=0.2,
        default=0.0,
        per="vector",
        source="chosen: dimensions of a gripper and what it holds",
    )
    radius: Array = parameter(
        "rho, radius of gyration about the centre of mass",
        role="span",
        unit="m",
        null=None,
        low=0.0,
        high=0.3,
        minimum=0.0,
        default=0.0,
        per="machine",
        source="chosen: a body of half a metre",
    )

    def in_description(self, robot: RobotDescription) -> RobotDescription:
        """Return the robot with the payload added to its tool."""
        return with_payload(robot, float(self.mass), self.offset, float(self.radius))
