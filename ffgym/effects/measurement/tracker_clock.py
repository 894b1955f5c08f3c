"""X3: a tracker whose samples come late, on a clock that runs otherwise."""

from dataclasses import dataclass
from typing import final

import numpy as np
import scipy

from ffgym.core.types import Array
from ffgym.effects.effect import TrackerEffect
from ffgym.effects.measurement.tool_position import replace_tool_positions
from ffgym.effects.parameters import parameter
from ffgym.recordings import Recording
from ffgym.robot import RobotDescription


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class TrackerClock(TrackerEffect):
    """Tool positions of another time than their time stamp says; before the motion the tool rests at its start."""

    name = "tracker_clock"
    code = "X3"
    title = "tracker latency and clock drift"
    equation = r"p_{meas}(t) = p(t - d - r\, t)"
    side = "tool"
    signature = "tool: proportional to its velocity; drift grows with time"
    way_in = "recorded tool positions; environments see the true tool"
    confusable_with = ("F2",)
    separating_motions = ("circles",)

    latency: Array = parameter(
        "d", unit="s", low=0.0, high=5e-3, per="machine", source="chosen: some samples of a tracker, 1 ms each"
    )
    drift: Array = parameter(
        "r", unit="1", low=-1e-4, high=1e-4, per="machine", source="tolerance of quartz clocks, up to 100 ppm"
    )

    def measure(self, recording: Recording, robot: RobotDescription) -> Recording:
        """Take tool positions at the instants at which they were really measured."""
        t = recording.t
        wanted = np.clip(t - self.latency - self.drift * t, t[0], t[-1])
        return replace_tool_positions(recording, lambda position: scipy.interpolate.CubicSpline(t, position)(wanted))
