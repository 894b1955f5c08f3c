"""X4: links that are not quite as long, and joints not quite at zero, as the kinematic model says."""

from dataclasses import dataclass, replace
from typing import final

from ffgym.core.types import Array
from ffgym.effects.effect import TrackerEffect
from ffgym.effects.measurement.tool_position import replace_tool_positions
from ffgym.effects.parameters import parameter
from ffgym.recordings import Recording
from ffgym.robot import RigidArm, RobotDescription


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class JointZeros(TrackerEffect):
    """Geometry that shows in the tool position; forces are too little changed by it to be changed here."""

    name = "joint_zeros"
    code = "X4"
    title = "joint zeros and link lengths"
    equation = r"p_{meas} = p + p_{(1 + e) l}(q + q_0) - p_l(q)"
    side = "tool"
    signature = "tool: a function of the pose, at rest too; nothing in torque"
    way_in = "recorded tool positions; environments see the true tool"
    confusable_with = ("X1", "X2")
    separating_motions = ("holds", "excitation")

    zero: Array = parameter(
        "q_0, link side", unit="rad", low=-5e-4, high=5e-4, source="chosen: half a millimetre in a metre, uncalibrated"
    )
    stretch: Array = parameter(
        "e, of the vector from the joint before to this one",
        unit="1",
        low=-1e-3,
        high=1e-3,
        minimum=-0.5,
        source="chosen: a millimetre in a metre, uncalibrated",
    )

    def measure(self, recording: Recording, robot: RobotDescription) -> Recording:
        """Shift tool positions by the difference of both kinematic models."""

        def seen(position: Array) -> Array:
            geometry = robot.kinematics
            longer = replace(geometry, position=geometry.position * (1 + self.stretch[:, None]))
            q = recording.joint_array("link.position")
            believed = RigidArm(robot).tcp_position(q)
            return position + RigidArm(replace(robot, kinematics=longer)).tcp_position(q + self.zero) - believed

        return replace_tool_positions(recording, seen)
