"""Agents in an environment, on many tasks side by side: what a policy sees, decides, and what the machine records."""

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode

from ffgym.control import Agent, ObservationLayout, Policy
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
    recorder, n = EpisodeRecorder(), len(tasks)
    view = policies[0].preview, policies[0].action_scale
    env = environment_for(plant, *view, len(policies) * n, recorder=recorder, n_threads=n_threads)
    core: TrackingCore = env.unwrapped.core
    robot, layout = core.robot, core.observation_layout
    # Agents decide on equal shares of the rows.
    decide = agents or [policy.agent(robot, layout) for policy in policies]
    own = [0] * len(policies) if seeds is None else list(seeds)
    each = [{"position": task.position, "speed": task.speed, "radii": task.radii} for task in tasks]
    of_rows = [seed + i for seed in own for i in range(n)]
    observation, _ = env.reset(seed=of_rows, options={"each": each * len(policies)})
    try:
        flights = _run(env, recorder, decide, observation, progress)
    finally:
        env.close()
    for i, flight in enumerate(flights):
        if flight.recording is not None:
            rng = np.random.default_rng(noise_seed(tasks[i % n], own[i // n]))
            flights[i] = replace(flight, recording=measure(flight.recording, plant.sensors, rng))
    return [flights[i : i + n] for i in range(0, len(flights), n)]


def environment_for(plant: TestPlant, preview: int, action_scale: float, n: int, **arguments: Any) -> Any:
    """Environment of a plant for a policy: `n` sub-environments that run each task to its end and wait."""
    return gym.make_vec(
        plant.env_id,
        num_envs=n,
        autoreset_mode=AutoresetMode.DISABLED,
        preview=preview,
        action_scale=action_scale,
        **dict(plant.env_arguments) | arguments,
    )


def _run(
    env: Any, recorder: EpisodeRecorder, agents: Sequence[Agent], observation: Array, progress: Progress | None
) -> list[Flight]:
    """Step until every motion has ended; what came of each row."""
    core: TrackingCore = env.unwrapped.core
    total, dt = sum(motion.n_steps for motion in core.motions if motion is not None), core.robot.servo.control_dt
    going: BoolArray = np.ones(len(observation), dtype=np.bool_)
    lengths = np.zeros(len(going), dtype=np.int64)
    starts, states, share = going.copy(), [None] * len(agents), len(going) // len(agents)
    actions: list[Array] = []
    recordings: dict[int, Recording] = {}
    while going.any():
        action = np.zeros((len(going), core.robot.n_joints))
        for i, agent in enumerate(agents):
            rows = slice(i * share, (i + 1) * share)
            if going[rows].any():
                action[rows], states[i] = agent.predict(observation[rows], states[i], starts[rows], True)
        starts[:] = False
        observation, _, terminated, truncated, _ = env.step(action)
        actions.append(np.clip(action, -1.0, 1.0))
        lengths += going
        ended = going & (terminated | truncated)
        recorded = zip(np.flatnonzero(ended).tolist(), recorder.recordings, strict=True)
        recordings |= {i: recording for i, recording in recorded if not terminated[i]}
        recorder.recordings.clear()
        going &= ~ended
        if progress is not None:
            progress(float(lengths.sum() * dt), total * dt)
    acted = np.stack(actions)
    return [Flight(recording=recordings.get(i), actions=acted[:length, i]) for i, length in enumerate(lengths)]


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
    env = environment_for(plant, preview, action_scale, 1, n_threads=1)
    observation, _ = env.reset(seed=0)
    core: TrackingCore = env.unwrapped.core
    env.close()
    return core.robot, core.observation_layout, observation
