"""Slow motion with rests of different lengths: how friction grows while a joint stands."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from ffgym.core.errors import FFGymError, check_number, check_shape
from ffgym.paths import joint_reference
from ffgym.paths.circles import DWELL
from ffgym.paths.excitations import SpeedStep, speed_steps
from ffgym.paths.motion import JointPath
from ffgym.paths.motions.part import entry
from ffgym.simulation.protocols.protocol import JointProtocol, Scheduled
from ffgym.simulation.protocols.stage import Stage

RAMP = 0.1
"""Time of each change of speed [s]; chosen: short, so that a restart is quick beside the rests."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class DwellRestart(JointProtocol):
    """Slow runs with rests between them, all joints together, and slowly back in one go."""

    name: ClassVar[str] = "dwell_restart"
    purpose: ClassVar[str] = "breakaway torque as a function of the time at rest before"

    rests: Sequence[float] = entry("how long the joints stand", "s", default=(0.1, 0.3, 1.0, 3.0, 10.0, 30.0))
    speed: float = entry("of the motors between rests", "rad/s", default=0.5)
    run: float = entry("time at that speed", "s", default=1.0)

    def motions(self, stage: Stage) -> list[Scheduled]:
        """One motion."""
        path = dwell_path(stage, stage.moved(self.joints), self.rests, self.speed, self.run, name="rests")
        return self.paused([joint_reference(stage.robot, path)])


def dwell_path(
    stage: Stage, joints: Sequence[int], rests: Sequence[float], speed: float, run: float, *, name: str
) -> JointPath:
    """Runs of the motors of some joints at a `speed` [rad/s] for `run` [s], with rests between them, and back."""
    rests = check_shape("rests", rests, (None,)).tolist()
    speed = check_number("speed", speed, unit="rad/s", low=0.0, open_low=True)
    run = check_number("run", run, unit="s", low=0.0, open_low=True)
    if not rests or min(rests) <= 0:
        raise FFGymError(f"rests = {rests} s must be > 0, at least one.")
    velocity = stage.only(joints, stage.joint_side(speed))
    way = velocity * (run + RAMP) * (len(rests) + 1)
    steps = [SpeedStep(velocity=velocity, duration=run, label="run 0")]
    for i, duration in enumerate(rests, start=1):
        steps.append(SpeedStep(velocity=np.zeros_like(velocity), duration=duration, label=f"rest of {duration:g} s"))
        steps.append(SpeedStep(velocity=velocity, duration=run, label=f"run {i} after {duration:g} s"))
    back = (run + RAMP) * (len(rests) + 1) - RAMP
    steps.append(SpeedStep(velocity=np.zeros_like(velocity), duration=DWELL, label="rest before the way back"))
    steps.append(SpeedStep(velocity=-velocity, duration=back, label="way back"))
    start = stage.about(stage.rest, way / 2) - way / 2
    return speed_steps(start, steps, ramp=RAMP, dwell=DWELL, dt=stage.dt, name=name)
