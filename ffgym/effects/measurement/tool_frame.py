"""X1: a reflector that is not where the tool is believed to be."""

from dataclasses import dataclass
from typing import final

import numpy as np

from ffgym.core.types import Array
from ffgym.effects.effect import TrackerEffect
from ffgym.effects.measurement.tool_position import replace_tool_positions
from ffgym.effects.parameters import parameter
from ffgym.recordings import Recording
from ffgym.robot import RigidArm, RobotDescription


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ToolFrame(TrackerEffect):
    """The tracked point is off the TCP, by a vector that turns with the flange."""

    name = "tool_frame"
    code = "X1"
    title = "tool frame"
    equation = r"p_{meas} = p + R(q)\, r"
    side = "tool"
    signature = "tool: an offset that turns with the flange, at rest too"
    way_in = "recorded tool positions; environments see the true tool"
    confusable_with = ("T1", "X2", "X4")
    separating_motions = ("holds", "excitation")

    offset: Array = parameter(
        "r, in the axes of tool0",
        unit="m",
        low=-2e-3,
        high=2e-3,
        per="vector",
        source="chosen: millimetres, as tool frames are taught by hand",
    )

    def measure(self, recording: Recording, robot: RobotDescription) -> Recording:
        """Shift tool positions by the offset, turned with the flange."""

        def seen(position: Array) -> Array:
            _, rotation = RigidArm(robot).tcp_pose(recording.joint_array("link.position"))
            return position + np.einsum("tij,j->ti", rotation, self.offset)

        return replace_tool_positions(recording, seen)
