"""Agents in an environment, on many tasks side by side: what a policy sees, decides, and what the machine records."""

import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode

from ffgym.control import Agent, Batchable, ObservationLayout, Policy
from ffgym.core.types import Array, BoolArray
from ffgym.envs import EpisodeRecorder
from ffgym.envs.core import TrackingCore
from ffgym.leaderboard.plants import TestPlant
from ffgym.leaderboard.tasks import Task, noise_seed
from ffgym.recordings import Recording
from ffgym.robot import RobotDescription
from ffgym.simulation.run import Progress
from ffgym.simulation.sensors import measure

TIMED = 100
"""Decisions that are timed for one robot alone; chosen: their median moves by some per cent from run to run."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Flight:
    """What came of one task."""

    recording: Recording | None
    """None if the robot stopped before the end of its motion."""
    actions: Array
    """As the agent gave them, clipped to [-1, 1], shape (T, N)."""


def fly(
    plant: TestPlant,
    policies: Sequence[Policy],
    tasks: Sequence[Task],
    *,
    agents: Sequence[Agent] | None = None,
    seeds: Sequence[int] | None = None,
    n_threads: int = 0,
    progress: Progress | None = None,
) -> list[list[Flight]]:
    """Run policies on tasks, all side by side in one environment; one list of flights per policy.

    Args:
        plant: the machine.
        policies: what acts; all with one preview and one action scale.
        tasks: motions for each of them.
        agents: who decides in place of the policies' own agents, e.g. in another process; None makes these.
        seeds: of the sensors' noise for each policy, None for 0; the same task and seed have the same noise for every
            policy, and for laws on the rig.
        n_threads: of the engine, 0 for all cores.
        progress: called now and then with the simulated seconds done and their total.

    Raises:
        FFGymError: if a policy does not fit the robot, or an action is not finite or has the wrong shape.
    """
    recorder = EpisodeRecorder()
    env = environment_for(plant, policies[0], len(policies) * len(tasks), recorder=recorder, n_threads=n_threads)
    core: TrackingCore = env.unwrapped.core
    robot, layout = core.robot, core.observation_layout
    own = [0] * len(policies) if seeds is None else list(seeds)
    decide = list(agents) if agents is not None else _deciding(policies, robot, layout)
    each = [{"position": task.position, "speed": task.speed, "radii": task.radii} for task in tasks]
    of_rows = [seed + i for seed in own for i in range(len(tasks))]
    observation, _ = env.reset(seed=of_rows, options={"each": each * len(policies)})
    flown = _Flown(core, recorder, len(policies), len(tasks))
    try:
        flown.run(env, decide, observation, progress)
    finally:
        env.close()
    for i, recording in flown.recordings.items():
        rng = np.random.default_rng(noise_seed(tasks[i % len(tasks)], own[i // len(tasks)]))
        flown.recordings[i] = measure(recording, plant.sensors, rng)
    return flown.flights()


def _deciding(policies: Sequence[Policy], robot: RobotDescription, layout: ObservationLayout) -> list[Agent]:
    """Agents that decide on equal shares of the rows: one for all policies if they can, one for each otherwise."""
    first, *others = policies
    if others and isinstance(first, Batchable):
        agent = first.batched_with(others, robot, layout)
        if agent is not None:
            return [agent]
    return [policy.agent(robot, layout) for policy in policies]


def environment_for(plant: TestPlant, policy: Policy, n: int, **arguments: Any) -> Any:
    """Environment of a plant for a policy: `n` sub-environments that run each task to its end and wait."""
    return gym.make_vec(
        plant.env_id,
        num_envs=n,
        autoreset_mode=AutoresetMode.DISABLED,
        preview=policy.preview,
        action_scale=policy.action_scale,
        **dict(plant.env_arguments) | arguments,
    )


class _Flown:
    """Books of the flights while they run; row p * K + k is policy p on task k."""

    def __init__(self, core: TrackingCore, recorder: EpisodeRecorder, n_policies: int, n_tasks: int) -> None:
        self.core, self.recorder = core, recorder
        self.shape = n_policies, n_tasks
        self.actions: list[Array] = []
        self.lengths = np.zeros(n_policies * n_tasks, dtype=np.int64)
        self.recordings: dict[int, Recording] = {}

    def run(self, env: Any, agents: Sequence[Agent], observation: Array, progress: Progress | None) -> None:
        """Step until every motion has ended."""
        total = sum(motion.n_steps for motion in self.core.motions if motion is not None)
        going: BoolArray = np.ones(len(self.lengths), dtype=np.bool_)
        starts, states, share = going.copy(), [None] * len(agents), len(going) // len(agents)
        while going.any():
            action = np.zeros((len(going), self.core.robot.n_joints))
            for i, agent in enumerate(agents):
                rows = slice(i * share, (i + 1) * share)
                if going[rows].any():
                    action[rows], states[i] = agent.predict(observation[rows], states[i], starts[rows], True)
            starts[:] = False
            observation, _, terminated, truncated, _ = env.step(action)
            self.actions.append(np.clip(action, -1.0, 1.0))
            self.lengths += going
            ended = going & (terminated | truncated)
            for i, recording in zip(np.flatnonzero(ended).tolist(), self.recorder.recordings, strict=True):
                if not terminated[i]:
                    self.recordings[i] = recording
            self.recorder.recordings.clear()
            going &= ~ended
            if progress is not None:
                dt = self.core.robot.servo.control_dt
                progress(float(self.lengths.sum() * dt), total * dt)

    def flights(self) -> list[list[Flight]]:
        """What came of each policy on each task."""
        n_policies, n_tasks = self.shape
        every = np.stack(self.actions)

        def flight(i: int) -> Flight:
            return Flight(recording=self.recordings.get(i), actions=every[: self.lengths[i], i])

        return [[flight(p * n_tasks + k) for k in range(n_tasks)] for p in range(n_policies)]


def inference_time(plant: TestPlant, policy: Policy) -> float:
    """Median time of one decision for one robot [us]; it waits at the start of a motion, which takes as long as any."""
    robot, layout, observation = _waiting(plant, policy.preview, policy.action_scale)
    agent = policy.agent(robot, layout)
    state, times = None, []
    for k in range(TIMED):
        began = time.perf_counter()
        _, state = agent.predict(observation, state, np.array([k == 0]), True)
        times.append(time.perf_counter() - began)
    return float(np.median(times)) * 1e6


@lru_cache(maxsize=8)
def _waiting(plant: TestPlant, preview: int, action_scale: float) -> tuple[RobotDescription, ObservationLayout, Array]:
    """What one robot of a plant shows an agent with such a view when a motion begins."""
    arguments = dict(plant.env_arguments) | {"preview": preview, "action_scale": action_scale, "n_threads": 1}
    env: Any = gym.make_vec(plant.env_id, num_envs=1, autoreset_mode=AutoresetMode.DISABLED, **arguments)
    observation, _ = env.reset(seed=0)
    core: TrackingCore = env.unwrapped.core
    env.close()
    return core.robot, core.observation_layout, observation
