"""Protocols in which the joints stand: rests between slow runs, and poses that load the motors differently."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from ffgym.core.errors import FFGymError, check_number, check_shape, check_whole
from ffgym.core.types import Array
from ffgym.paths import Reference, joint_reference
from ffgym.paths.circles import DWELL
from ffgym.paths.excitations import SpeedStep, speed_steps
from ffgym.paths.motion import JointPath
from ffgym.paths.motions.part import entry
from ffgym.simulation.protocols.protocol import JointProtocol, Scheduled
from ffgym.simulation.protocols.stage import ProtocolStage, spread_poses

QUICK_RAMP = 0.1
"""Time of each change of speed [s]; chosen: short, so that a restart is quick beside the rests."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class DwellRestart(JointProtocol):
    """Slow runs with rests between them, all joints together, and slowly back in one go."""

    name = "dwell_restart"
    purpose = "breakaway torque as a function of the time at rest before"

    rests: Sequence[float] = entry("how long the joints stand", "s", default=(0.1, 0.3, 1.0, 3.0, 10.0, 30.0))
    speed: float = entry("of the motors between rests", "rad/s", default=0.5)
    run: float = entry("time at that speed", "s", default=1.0)

    def motions(self, stage: ProtocolStage) -> list[Scheduled]:
        """Make the one motion."""
        path = dwell_path(stage, stage.select_joints(self.joints), self.rests, self.speed, self.run, name="rests")
        return self.schedule_all([joint_reference(stage.robot, path)])


def dwell_path(
    stage: ProtocolStage, joints: Sequence[int], rests: Sequence[float], speed: float, run: float, *, name: str
) -> JointPath:
    """Make runs of the motors of some joints at a `speed` [rad/s] for `run` [s], with rests between them, and back."""
    rests = check_shape("rests", rests, (None,)).tolist()
    speed = check_number("speed", speed, unit="rad/s", low=0.0, open_low=True)
    run = check_number("run", run, unit="s", low=0.0, open_low=True)
    if not rests or min(rests) <= 0:
        raise FFGymError(f"rests = {rests} s must be > 0, at least one.")
    velocity = stage.only(joints, stage.joint_side(speed))
    way = velocity * (run + QUICK_RAMP) * (len(rests) + 1)
    steps = [SpeedStep(velocity=velocity, duration=run, label="run 0")]
    for i, duration in enumerate(rests, start=1):
        steps.append(SpeedStep(velocity=np.zeros_like(velocity), duration=duration, label=f"rest of {duration:g} s"))
        steps.append(SpeedStep(velocity=velocity, duration=run, label=f"run {i} after {duration:g} s"))
    back = (run + QUICK_RAMP) * (len(rests) + 1) - QUICK_RAMP
    steps.append(SpeedStep(velocity=np.zeros_like(velocity), duration=DWELL, label="rest before the way back"))
    steps.append(SpeedStep(velocity=-velocity, duration=back, label="way back"))
    start = stage.about(stage.rest, way / 2) - way / 2
    return speed_steps(start, steps, ramp=QUICK_RAMP, dwell=DWELL, dt=stage.dt, name=name)


SPEED = 1.0
"""Motor speed of the approach [rad/s]; chosen: above the Stribeck speeds of gearboxes, and slow enough not to swing."""

RAMP = 0.2
"""Time of each change of speed [s]."""

MOST_POSES = 50
"""Largest number of poses; more are surely a slip."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Holds(JointProtocol):
    """Rests in several poses, approached by all joints from below and from above.

    Half the sum of both torques is load, half their difference is friction.
    """

    name = "holds"
    purpose = "gravity, payload, torque offset and sag, apart from friction"

    poses: int = entry("how many poses", default=6)
    rest: float = entry("how long each rest is", "s", default=2.0)
    approach: float = entry("way of the motors towards the pose", "rad", default=2.0)

    def motions(self, stage: ProtocolStage) -> list[Scheduled]:
        """Make one motion for each pose."""
        count = check_whole("poses", self.poses, low=1, high=MOST_POSES)
        check_number("rest", self.rest, unit="s", low=0.0, open_low=True)
        check_number("approach", self.approach, unit="rad", low=2 * SPEED * RAMP, high=100.0)
        way = stage.only(stage.select_joints(self.joints), stage.joint_side(self.approach))
        poses = spread_poses(stage, count, way)
        return self.schedule_all([self._hold(stage, pose, way, i) for i, pose in enumerate(poses, start=1)])

    def _hold(self, stage: ProtocolStage, pose: Array, way: Array, number: int) -> Reference:
        """Make a motion from below the pose to it, beyond it, and back to it from above."""
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
