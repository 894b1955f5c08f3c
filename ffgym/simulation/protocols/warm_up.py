"""One motion again and again over the day: what temperature does to friction."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, final

import numpy as np

from ffgym.core.errors import FFGymError, check_number, check_shape
from ffgym.paths.motions.part import entry
from ffgym.simulation.protocols.protocol import JointProtocol, Scheduled
from ffgym.simulation.protocols.stage import Stage, shrunk
from ffgym.simulation.protocols.together import own_sines


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class WarmUp(JointProtocol):
    """The same sines of all joints at times that double, while the machine works in between and warms up."""

    name: ClassVar[str] = "warm_up"
    purpose: ClassVar[str] = "change of friction with temperature; let the machine work between the recordings"

    times: Sequence[float] = entry(
        "starts of the motion, since the first one", "s", default=(0.0, 300.0, 600.0, 1200.0, 2400.0, 4800.0, 9600.0)
    )
    speed: float = entry("largest speed of the motors", "rad/s", default=60.0)
    frequency: float = entry("of the first joint's sine", "Hz", default=0.3)
    duration: float = entry("of the motion", "s", default=10.0)

    def motions(self, stage: Stage) -> list[Scheduled]:
        """One for each time."""
        times = check_shape("times", self.times, (None,))
        joints = stage.moved(self.joints)
        speed = check_number("speed", self.speed, unit="rad/s", low=0.0, open_low=True)
        frequency = check_number("frequency", self.frequency, unit="Hz", low=0.0, open_low=True)
        path = own_sines(stage, joints, speed, frequency, self.duration, name="0")
        reference = shrunk(stage, path)
        if not len(times) or times[0] != 0 or (np.diff(times) < reference.duration).any():
            raise FFGymError(
                f"times = {times.tolist()} s must begin with 0 and lie at least {reference.duration:g} s apart, as the "
                f"motion takes so long."
            )
        pauses = [self.pause, *(np.diff(times) - reference.duration)]
        return [
            Scheduled(reference=replace(reference, name=f"at_{time:g}_s"), pause=pause)
            for time, pause in zip(times, pauses, strict=True)
        ]
