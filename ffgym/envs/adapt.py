"""`ffgym/Adapt-v0`: a machine that nobody has seen, a budget of motion on it, then circles that count."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ffgym.core.errors import FFGymError, check_number, check_whole
from ffgym.envs.circle_path import CircleTasks, Position
from ffgym.envs.motion import EpisodeMotion
from ffgym.envs.single import TrackingEnv
from ffgym.envs.tasks import Tasks
from ffgym.envs.vector import TrackingVectorEnv
from ffgym.paths import RADII
from ffgym.robot import RobotDescription
from ffgym.simulation.plant import LogUniform, PlantDistribution, Uniform

MACHINES = PlantDistribution(
    friction_level=LogUniform(0.7, 1.4),
    viscous=LogUniform(0.5, 2.0),
    joint_stiffness=LogUniform(0.7, 1.4),
    link_inertia=LogUniform(0.85, 1.18),
    rotor_inertia=LogUniform(0.85, 1.18),
    arm_share=Uniform(0.2, 0.9),
    torque_lag=LogUniform(0.5, 2.0),
    torque_delay=LogUniform(0.5, 2.0),
    torque_rate=LogUniform(0.5, 2.0),
    payload=Uniform(0.0, 10.0),
)
"""Machines that are drawn if none are given; chosen: as wide as a series of one robot, see docs/workcell.md."""


class AdaptTasks(Tasks):
    """Laps of one circle for practice, then circles elsewhere that are scored, on one machine.

    Args:
        robot: nominal one of the controller: description, built-in name, or path to a description ending in .toml;
            it must have a work area.
        budget: time of practice [s]: as many whole laps as fit into it, with leads and rests.
        practice_position: place of the circle of practice: a name of the work area, or a point [m].
        practice_speed: speed of practice [m/s].
        practice_radius: radius of the circle of practice [m].
        positions: places of circles that count: names in the work area, or points [m].
        speeds: their speeds [m/s].
        radii: their radii [m].
        scored: number of motions that count, each at a place and a speed that are drawn, with all radii.
    """

    option_names = ("budget", "position", "speed", "radii")

    def __init__(
        self,
        robot: RobotDescription | str | Path = "irb4600_60_205_arm_drives",
        *,
        budget: float = 3.0,
        practice_position: Position = "p1",
        practice_speed: float = 0.04,
        practice_radius: float = 0.003,
        positions: Sequence[Position] = ("p2", "p3", "p4"),
        speeds: Sequence[float] = (0.02, 0.04, 0.1),
        radii: Sequence[float] = RADII,
        scored: int = 2,
    ) -> None:
        super().__init__(robot)
        self._budget, self._scored = (
            check_number("budget", budget, unit="s", low=0.0),
            check_whole("scored", scored, low=1),
        )
        self._practice = CircleTasks(
            self.robot, positions=[practice_position], speeds=[practice_speed], radii=[practice_radius]
        )
        self._radius = practice_radius
        self._circles = CircleTasks(self.robot, positions=positions, speeds=speeds, radii=radii)
        self.count_laps(self._budget)  # refuse now, not in the middle of a training

    def count_laps(self, budget: float) -> int:
        """Count the whole laps of practice that fit into a budget [s].

        Raises:
            FFGymError: if the budget is larger than 0 and holds none.
        """
        rng = np.random.default_rng(0)
        first, second = (
            self._practice.draw(rng, {"radii": [self._radius] * laps}).reference.duration for laps in (1, 2)
        )
        if 0 < budget < first:
            raise FFGymError(f"budget = {budget:g} s must be 0 or at least {first:.3f} s, one lap with its leads.")
        return 0 if budget == 0 else 1 + int((budget - first) / (second - first) + 1e-9)

    def draw(self, rng: np.random.Generator, options: Mapping[str, Any]) -> EpisodeMotion:
        """Draw the first motion of an episode."""
        return self.draw_series(rng, options)[0]

    def draw_series(self, rng: np.random.Generator, options: Mapping[str, Any]) -> tuple[EpisodeMotion, ...]:
        """Draw the motions that count, behind the laps of practice."""
        budget = check_number("budget", options.get("budget", self._budget), unit="s", low=0.0)
        chosen = {name: value for name, value in options.items() if name != "budget"}
        motions = [self._circles.draw(rng, chosen) for _ in range(self._scored)]
        if laps := self.count_laps(budget):
            practice = self._practice.draw(rng, {"radii": [self._radius] * laps})
            motions.insert(0, self._keep_motion(("practice", laps), lambda: replace(practice, is_practice=True)))
        return tuple(motions)


class AdaptVectorEnv(TrackingVectorEnv):
    """Six-axis robots on machines that were never seen.

    Keyword arguments are those of `AdaptTasks` and of `ffgym.envs.EnvSettings`; without plant and randomization each
    episode has a machine of its own, drawn from `ffgym.envs.adapt.MACHINES`.
    """

    tasks = AdaptTasks

    def __init__(self, num_envs: int = 1, **arguments: Any) -> None:
        if arguments.get("plant") is None:
            arguments.setdefault("randomization", MACHINES)
        super().__init__(num_envs, **arguments)


class AdaptEnv(TrackingEnv):
    """One six-axis robot on machines that were never seen; keyword arguments as `AdaptVectorEnv`."""

    kind = AdaptVectorEnv
