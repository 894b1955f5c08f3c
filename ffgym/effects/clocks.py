"""Sensors whose samples stand in rows of another time (X3, X5, X6)."""

from dataclasses import dataclass
from typing import final

import numpy as np
import scipy

from ffgym.core.types import Array
from ffgym.effects.effect import ClockEffect, TrackerEffect
from ffgym.effects.frames import with_tool_at
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

    def measured(self, recording: Recording, robot: RobotDescription) -> Recording:
        """See base class."""
        t = recording.t
        wanted = np.clip(t - self.latency - self.drift * t, t[0], t[-1])
        return with_tool_at(recording, lambda position: scipy.interpolate.CubicSpline(t, position)(wanted))


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class TorqueClock(ClockEffect):
    """Motor torques in rows of a later time than the positions beside them, all joints alike.

    The opposite, a torque that acts after its row, is the delay of the drive or of the positions' way into the log.
    """

    name = "torque_clock"
    code = "X5"
    title = "torque out of step with position"
    equation = r"u_{log}(t) = u(t - d)"
    side = "controller"
    signature = "torque of all joints: proportional to its own rate of change, with one and the same time"
    way_in = "recorded motor torques; nothing that acts on the machine changes"
    confusable_with = ("M5",)
    separating_motions = ("excitation",)
    families = ("motor.effort",)

    latency: Array = parameter(
        "d",
        unit="s",
        low=0.0,
        high=0.02,
        minimum=0.0,
        per="machine",
        source="chosen: some rows of a log of 100 to 1000 Hz; at 10 Hz a single row is 0.1 s",
    )


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class LinkClock(ClockEffect):
    """Link positions in rows of a later time than the motor positions beside them, all joints alike.

    Drawn over the motor angle, or over the sign of its speed, it is a loop as of backlash; unlike one, it grows with
    the speed.
    """

    name = "link_clock"
    code = "X6"
    title = "link encoders out of step with motor encoders"
    equation = r"q_{log}(t) = q(t - d)"
    side = "link"
    signature = "link encoder: proportional to the speed of its joint, torque nothing"
    way_in = "recorded link positions and speeds; nothing that acts on the machine changes"
    confusable_with = ("T4",)
    separating_motions = ("speed_ladder", "slow_triangles")
    families = ("link.position", "link.velocity")

    latency: Array = parameter(
        "d",
        unit="s",
        low=0.0,
        high=0.005,
        minimum=0.0,
        per="machine",
        source="chosen: a cycle or two of a drive's bus, 1 to 4 ms each",
    )
