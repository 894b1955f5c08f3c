"""Standing still in poses that load the motors differently, each reached from both sides."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from ffgym.core.errors import check_number, check_whole
from ffgym.core.types import Array
from ffgym.paths import Reference, joint_reference
from ffgym.paths.circles import DWELL
from ffgym.paths.excitations import SpeedStep, speed_steps
from ffgym.paths.motions.part import entry
from ffgym.simulation.protocols.protocol import JointProtocol, Scheduled
from ffgym.simulation.protocols.stage import Stage, spread_poses

SPEED = 1.0
"""Motor speed of the approach [rad/s]; chosen: above the Stribeck speeds of gearboxes, and slow enough not to swing."""

RAMP = 0.2
"""Time of each change of speed [s]."""

MOST_POSES = 50
"""Most poses; more are surely a slip."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Holds(JointProtocol):
    """Rests in several poses, approached by all joints from below and from above.

    Half the sum of both torques is load, half their difference is friction.
    """

    name: ClassVar[str] = "holds"
    purpose: ClassVar[str] = "gravity, payload, torque offset and sag, apart from friction"

    poses: int = entry("how many poses", default=6)
    rest: float = entry("how long each rest is", "s", default=2.0)
    approach: float = entry("way of the motors towards the pose", "rad", default=2.0)

    def motions(self, stage: Stage) -> list[Scheduled]:
        """One for each pose."""
        count = check_whole("poses", self.poses, low=1, high=MOST_POSES)
        check_number("rest", self.rest, unit="s", low=0.0, open_low=True)
        check_number("approach", self.approach, unit="rad", low=2 * SPEED * RAMP, high=100.0)
        way = stage.only(stage.moved(self.joints), stage.joint_side(self.approach))
        poses = spread_poses(stage, count, way)
        return self.paused([self._hold(stage, pose, way, i) for i, pose in enumerate(poses, start=1)])

    def _hold(self, stage: Stage, pose: Array, way: Array, number: int) -> Reference:
        """From one way below the pose to it, beyond it, and back to it from above."""
        velocity, still = way / self.approach * SPEED, np.zeros_like(way)
        towards = self.approach / SPEED - RAMP  # a ramp from rest and one to rest cover as much as one at full speed
        steps = [
            SpeedStep(velocity=velocity, duration=towards, label="approach from below"),
            SpeedStep(velocity=still, duration=self.rest, label="rest from below"),
            SpeedStep(velocity=velocity, duration=towards, label="beyond"),
            SpeedStep(velocity=-velocity, duration=towards, label="approach from above"),
            SpeedStep(velocity=still, duration=self.rest, label="rest from above"),
        ]
        path = speed_steps(pose - way, steps, ramp=RAMP, dwell=DWELL, dt=stage.dt, name=f"pose_{number}")
        return joint_reference(stage.robot, path)
