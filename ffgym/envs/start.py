"""Start of an episode: motion, plant, reward and sensing, drawn or fixed by options."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np

from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.types import IntArray
from ffgym.envs.machines import find_machine
from ffgym.envs.motion import EpisodeMotion
from ffgym.envs.rewards import Reward, find_reward
from ffgym.envs.settings import EnvSettings, check_horizon, check_kind, find_sensing
from ffgym.envs.tasks import Sensing, Tasks, copy_changing
from ffgym.simulation.plant import Machine

COMMON_OPTIONS = ("plant", "randomization", "reward", "sensing", "horizon")
"""Options of `reset(options=...)` in every environment."""


@dataclass(frozen=True, kw_only=True, eq=False)
class EpisodeStart:
    """Checked start of an episode."""

    motion: EpisodeMotion
    then: tuple[EpisodeMotion, ...]
    """Motions that follow in the same episode."""
    machine: Machine
    """Simulated machine."""
    horizon: int | None
    """Control steps after which the episode ends; None runs all motions to their ends."""
    reward: Reward
    sensing: Sensing
    noise: np.random.Generator
    """Randomness of the sensors, of this episode alone, so that no later draw depends on how long it lasts."""


class Starts:
    """Draws the episodes of B sub-environments, each with randomness of its own."""

    def __init__(self, tasks: Tasks, n: int, settings: EnvSettings) -> None:
        self.tasks, self._n, self._settings = tasks, n, settings
        plant = settings.plant
        listed = plant if isinstance(plant, Sequence) and not isinstance(plant, str) else (plant,)
        self.machines = [Machine.of(tasks.robot) if one is None else find_machine(one) for one in listed]
        """Simulated machines, one of which is drawn for each episode, before randomisation."""
        if not self.machines:
            raise FFGymError("plant = [] must name at least one machine, e.g. plant=['workcell:drives-1'].")
        self._listed = tasks.list_options() if settings.sampling == "sequence" else []
        if settings.sampling == "sequence" and not self._listed:
            raise FFGymError("sampling = 'sequence' needs motions that can be listed; random motions cannot.")
        self.rngs: list[np.random.Generator | None] = [None] * n
        """Randomness of each sub-environment; None before its first reset."""
        self._episodes: IntArray = np.zeros(n, dtype=np.int64)

    def seed(self, i: int, rng: np.random.Generator, fresh: bool) -> None:
        """Give a sub-environment its randomness; a `fresh` one begins the sequence of motions anew."""
        self.rngs[i] = rng
        if fresh:
            self._episodes[i] = 0

    def draw(self, ids: IntArray, options: Sequence[Mapping[str, Any]]) -> list[EpisodeStart]:
        """Draw the next episodes of sub-environments `ids`, with options for each.

        Raises:
            FFGymError: if an option is unknown or not valid.
        """
        for chosen in options:
            for name in chosen:
                check_choice("reset option", name, [*self.tasks.option_names, *COMMON_OPTIONS])
        starts = [self._draw(i, chosen) for i, chosen in zip(ids, options, strict=True)]
        self._episodes[ids] += 1
        return starts

    def _draw(self, i: int, options: Mapping[str, Any]) -> EpisodeStart:
        """Draw the next episode: its motion first, then its plant, then the randomness of its sensors."""
        rng, settings = self.rngs[i], self._settings
        assert rng is not None  # the environment seeds before it resets
        horizon = check_horizon(options.get("horizon", settings.horizon))
        reward = find_reward(options.get("reward", settings.reward), self.tasks.robot)
        sensing = find_sensing(options.get("sensing", settings.sensing))
        distribution = check_kind("randomization", options.get("randomization", settings.randomization))
        task = {k: v for k, v in options.items() if k in self.tasks.option_names and v is not None}
        if self._listed:
            task = self._listed[int(i + self._episodes[i] * self._n) % len(self._listed)] | task
        motion, *then = self.tasks.draw_series(rng, task)
        machine = self.machines[0] if len(self.machines) == 1 else self.machines[int(rng.integers(len(self.machines)))]
        if options.get("plant") is not None:
            machine = find_machine(options["plant"])
        if distribution is not None:
            machine = machine.with_robot(distribution.draw(machine.robot, rng))
        return EpisodeStart(
            motion=motion,
            then=tuple(then),
            machine=machine,
            horizon=horizon,
            reward=reward,
            sensing=sensing,
            noise=np.random.default_rng(rng.integers(2**63)),
        )

    def save(self) -> dict[str, Any]:
        """Copy randomness and places in the sequence."""
        return copy_changing(self, ("rngs", "_episodes"))

    @contextmanager
    def all_or_nothing(self) -> Iterator[None]:
        """Leave randomness and sequence as they were if the block fails."""
        rngs, episodes = self.rngs.copy(), self._episodes.copy()
        drawn = [(rng.bit_generator, rng.bit_generator.state) for rng in rngs if rng is not None]
        try:
            yield
        except BaseException:
            self.rngs, self._episodes = rngs, episodes
            for bits, was in drawn:
                bits.state = was
            raise
