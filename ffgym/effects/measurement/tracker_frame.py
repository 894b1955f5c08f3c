"""X2: a tracker whose frame is not quite the robot's."""

from dataclasses import dataclass
from typing import final

import scipy

from ffgym.core.types import Array
from ffgym.effects.effect import TrackerEffect
from ffgym.effects.measurement.tool_position import replace_tool_positions
from ffgym.effects.parameters import parameter
from ffgym.recordings import Recording
from ffgym.robot import RobotDescription


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class TrackerFrame(TrackerEffect):
    """Positions turned and shifted about the robot's base, and longer or shorter by a share."""

    name = "tracker_frame"
    code = "X2"
    title = "tracker frame and scale"
    equation = r"p_{meas} = (1 + s)\, R(\phi)\, p + t"
    side = "tool"
    signature = "tool: an affine function of its position, at rest too"
    way_in = "recorded tool positions; environments see the true tool"
    confusable_with = ("T1", "T7", "X1", "X4")
    separating_motions = ("holds", "excitation")

    shift: Array = parameter(
        "t", unit="m", low=-2e-3, high=2e-3, per="vector", source="chosen: millimetres, as frames are fitted to points"
    )
    turn: Array = parameter(
        "phi, rotation vector", unit="rad", low=-1e-3, high=1e-3, per="vector", source="chosen: a millimetre in a metre"
    )
    scale: Array = parameter(
        "s", unit="1", low=-1e-4, high=1e-4, minimum=-0.5, per="machine", source="chosen: some K of thermal expansion"
    )

    def measure(self, recording: Recording, robot: RobotDescription) -> Recording:
        """Transform tool positions into the frame of the tracker."""
        turn = scipy.spatial.transform.Rotation.from_rotvec(self.turn.copy()).as_matrix()
        return replace_tool_positions(recording, lambda position: (1 + self.scale) * position @ turn.T + self.shift)
