"""Large sums of sines of all joints, for rigid-body identification."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from ffgym.core.errors import check_number, check_whole
from ffgym.paths.motions.part import entry
from ffgym.simulation.protocols.protocol import JointProtocol, Scheduled
from ffgym.simulation.protocols.stage import Stage
from ffgym.simulation.protocols.together import fade_of, large_multisine

MOST = 100
"""Most motions, sines and periods; more are surely a slip."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Excitation(JointProtocol):
    """Harmonics with random phases on all joints at once, as large as joint ranges, speeds and torques allow.

    Reference:
        Swevers, Ganseman, Tukel, De Schutter, Van Brussel (1997), IEEE Trans. Robotics and Automation 13(5), 730-740:
        periodic excitation by a sum of harmonics.
    """

    name: ClassVar[str] = "excitation"
    purpose: ClassVar[str] = "inertial parameters of the links; the last motion may validate"

    count: int = entry("how many motions, with different phases", default=3)
    base: float = entry("lowest frequency, of which the others are multiples", "Hz", default=0.1)
    harmonics: int = entry("how many sines on each joint", default=10)
    periods: int = entry("how many periods of the lowest frequency", default=2)
    reach: float = entry("farthest way of a joint to either side, as a share of its range", default=0.15)
    seed: int = entry("of the phases", default=0)

    def motions(self, stage: Stage) -> list[Scheduled]:
        """One for each set of phases."""
        count = check_whole("count", self.count, low=1, high=MOST)
        harmonics = check_whole("harmonics", self.harmonics, low=1, high=MOST)
        periods = check_whole("periods", self.periods, low=1, high=MOST)
        base = check_number("base", self.base, unit="Hz", low=0.0, open_low=True)
        reach = check_number("reach", self.reach, low=0.0, high=0.5, open_low=True)
        frequencies = base * np.arange(1, harmonics + 1, dtype=np.float64)
        joints, duration = stage.moved(self.joints), periods / base + 2 * fade_of(frequencies)
        shape = (harmonics, stage.robot.n_joints)
        generators = np.random.default_rng(check_whole("seed", self.seed, low=0)).spawn(count)
        return self.paused(
            [
                large_multisine(
                    stage, joints, frequencies, rng.uniform(0, 2 * np.pi, shape), reach, duration, name=f"phases_{i}"
                )
                for i, rng in enumerate(generators, start=1)
            ]
        )
