"""Rollouts of agents in an environment, on many tasks side by side: observations, decisions and recordings."""

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any
from zlib import crc32

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode

from ffgym.control import Agent, ObservationLayout, Policy, find_channel, sees_errors
from ffgym.control.observation import Channel
from ffgym.core.errors import FFGymError
from ffgym.core.registration import find_spec
from ffgym.core.types import Array, BoolArray
from ffgym.envs import EpisodeRecorder
from ffgym.envs.core import TrackingCore
from ffgym.leaderboard.motions import CIRCLE
from ffgym.leaderboard.plants import TestPlant
from ffgym.leaderboard.tasks import TRAIN_POSITION, Task, make_references, noise_seed
from ffgym.paths import RADII, SPEEDS, Reference
from ffgym.recordings import Recording
from ffgym.robot import RobotDescription
from ffgym.simulation import RECORD_DT, Rig
from ffgym.simulation.plant import Machine
from ffgym.simulation.run import Progress
from ffgym.simulation.sensors import measure

TIMED = 100
"""Decisions that are timed for one robot alone; chosen: their median moves by some per cent from run to run."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Rollout:
    """Recording and actions of one task."""

    recording: Recording | None
    """Recording of the run; None if the robot stopped before the end of its motion."""
    actions: Array
    """Actions of the agent, clipped to [-1, 1], shape (T, N)."""


def run_rollouts(
    plant: TestPlant,
    policies: Sequence[Policy],
    tasks: Sequence[Task],
    *,
    machines: Sequence[TestPlant] | None = None,
    agents: Sequence[Agent] | None = None,
    seeds: Sequence[int] | None = None,
    n_threads: int = 0,
    progress: Progress | None = None,
) -> list[list[Rollout]]:
    """Run policies on tasks, all side by side in one environment; return one list of rollouts per policy.

    Args:
        plant: the machine.
        machines: machine of each task, all under the controller of `plant`, each with noise of its own; None runs
            every task on `plant`.
        policies: policies to run, all with one preview, action scale, track and channel; those of the track
            feed-forward observe no errors, those of the channel 'setpoint' correct set-points.
        tasks: motions for each of them.
        agents: agents in place of the policies' own, e.g. in another process; None makes these.
        seeds: seed of the sensors' noise for each policy, None for 0; one task and seed have the same noise for every
            policy, and for laws on the rig.
        n_threads: threads of the engine, 0 for all cores.
        progress: function that is called now and then with the simulated seconds done and their total.

    Raises:
        FFGymError: if a policy does not fit the robot, or an action is not finite or has the wrong shape.
    """
    recorder, n = EpisodeRecorder(), len(tasks)
    views = {(policy.preview, policy.action_scale, sees_errors(policy), find_channel(policy)) for policy in policies}
    if len(views) > 1:
        raise FFGymError(
            f"Policies must have one preview, action scale, track and channel to run side by side, got {views}."
        )
    [(preview, scale, feedback, channel)] = views
    size = len(policies) * n
    of_tasks = [plant] * n if machines is None else list(machines)
    made: dict[str, Any] = {"feedback": feedback, "channel": channel, "recorder": recorder, "n_threads": n_threads}
    if all(task.kind == CIRCLE for task in tasks):
        env = environment_for(plant, preview, scale, size, **made)
        each: list[dict[str, Any]] = [{"position": t.place, "speed": t.speed, "radii": t.radii} for t in tasks]
    else:
        references = make_references(plant.rig.arm, tasks)
        env = _environment_along(plant.rig.robot, plant.machine, references, preview, scale, size, **made)
        each = [{"path": reference} for reference in references]
    core: TrackingCore = env.unwrapped.core
    robot, layout = core.robot, core.observation_layout
    # agents decide on equal shares of the rows
    decide = agents or [policy.agent(robot, layout) for policy in policies]
    own = [0] * len(policies) if seeds is None else list(seeds)
    if machines is not None:
        each = [one | {"plant": machine.machine} for one, machine in zip(each, of_tasks, strict=True)]
    of_rows = [seed + i for seed in own for i in range(n)]
    observation, _ = env.reset(seed=of_rows, options={"each": each * len(policies)})
    try:
        rollouts = _run(env, recorder, decide, observation, progress)
    finally:
        env.close()
    # sensors' noise by task, seed and machine, whatever runs beside
    for i, rollout in enumerate(rollouts):
        if rollout.recording is not None:
            of_machine = [] if machines is None else [crc32(machines[i % n].name.encode())]
            rng = np.random.default_rng([*noise_seed(tasks[i % n], own[i // n]), *of_machine])
            rollouts[i] = replace(rollout, recording=measure(rollout.recording, of_tasks[i % n].sensors, rng))
    return [rollouts[i : i + n] for i in range(0, len(rollouts), n)]


def run_references(
    rig: Rig,
    policy: Policy,
    references: Sequence[Reference],
    *,
    seed: int = 0,
    record_dt: float = RECORD_DT,
    n_threads: int = 0,
    progress: Progress | None = None,
) -> list[Recording | None]:
    """Run a policy along any motions on a rig, all side by side in one environment.

    Args:
        rig: the machine under its controller; a simulated one without parts left out.
        policy: the policy, which observes the motors through a resolver.
        references: motions of the controller's robot.
        seed: seed of the sensors' noise.
        record_dt: sample time of the recordings [s].
        n_threads: threads of the engine, 0 for all cores.
        progress: function that is called now and then with the simulated seconds done and their total.

    Returns:
        Recordings as the rig makes them, one per motion; None where the robot stopped before the end.

    Raises:
        FFGymError: if the policy does not fit the robot, or an action is not finite or has the wrong shape.
    """
    recorder = EpisodeRecorder(record_dt=record_dt)
    env = _environment_along(
        rig.robot,
        rig.machine,
        references,
        policy.preview,
        policy.action_scale,
        len(references),
        feedback=sees_errors(policy),
        channel=find_channel(policy),
        recorder=recorder,
        n_threads=n_threads,
    )
    try:
        core: TrackingCore = env.unwrapped.core
        agent = policy.agent(core.robot, core.observation_layout)
        each = [{"path": reference} for reference in references]
        observation, _ = env.reset(seed=seed, options={"each": each})
        rollouts = _run(env, recorder, [agent], observation, progress)
    finally:
        env.close()
    sensors, noise = getattr(rig, "sensors", ()), np.random.default_rng(seed).spawn(len(references))
    recordings = [rollout.recording for rollout in rollouts]
    return [None if each is None else measure(each, sensors, rng) for each, rng in zip(recordings, noise, strict=True)]


def environment_for(
    plant: TestPlant,
    preview: int,
    action_scale: float,
    n: int,
    *,
    feedback: bool = True,
    channel: Channel = "torque",
    **arguments: Any,
) -> Any:
    """Make the environment of a plant: `n` sub-environments that run each task to its end and wait.

    Without `feedback` they show no errors of the motors; in the channel 'setpoint' actions correct set-points.
    """
    return gym.make_vec(
        find_spec(plant.env_id),
        num_envs=n,
        autoreset_mode=AutoresetMode.DISABLED,
        preview=preview,
        action_scale=action_scale,
        track="feedback" if feedback else "feed-forward",
        channel=channel,
        **dict(plant.env_arguments) | arguments,
    )


def _environment_along(
    robot: RobotDescription,
    machine: Machine | None,
    references: Sequence[Reference],
    preview: int,
    action_scale: float,
    n: int,
    *,
    feedback: bool,
    channel: Channel,
    **arguments: Any,
) -> Any:
    """Make the environment of a machine along any motions, for the rest as `environment_for`."""
    return gym.make_vec(
        find_spec("ffgym/FollowPath-v0"),
        num_envs=n,
        autoreset_mode=AutoresetMode.DISABLED,
        robot=robot,
        plant=machine,
        path=list(references),
        preview=preview,
        action_scale=action_scale,
        track="feedback" if feedback else "feed-forward",
        channel=channel,
        sensing="resolver",
        **arguments,
    )


def _run(
    env: Any, recorder: EpisodeRecorder, agents: Sequence[Agent], observation: Array, progress: Progress | None
) -> list[Rollout]:
    """Step until every motion has ended; return the rollout of each row."""
    core: TrackingCore = env.unwrapped.core
    total, dt = sum(motion.n_steps for motion in core.motions if motion is not None), core.robot.servo.control_dt
    going: BoolArray = np.ones(len(observation), dtype=np.bool_)
    lengths = np.zeros(len(going), dtype=np.int64)
    starts, states, share = going.copy(), [None] * len(agents), len(going) // len(agents)
    actions: list[Array] = []
    recordings: dict[int, Recording] = {}
    while going.any():
        # decisions of the agents whose motions still run
        action = np.zeros((len(going), core.robot.n_joints))
        for i, agent in enumerate(agents):
            rows = slice(i * share, (i + 1) * share)
            if going[rows].any():
                action[rows], states[i] = agent.predict(observation[rows], states[i], starts[rows], True)
        starts[:] = False
        observation, _, terminated, truncated, _ = env.step(action)
        actions.append(np.clip(action, -1.0, 1.0))
        lengths += going
        # recordings of motions that end here; emergency stops have none
        ended = going & (terminated | truncated)
        recorded = zip(np.flatnonzero(ended).tolist(), recorder.recordings, strict=True)
        recordings |= {i: recording for i, recording in recorded if not terminated[i]}
        recorder.recordings.clear()
        going &= ~ended
        if progress is not None:
            progress(float(lengths.sum() * dt), total * dt)
    acted = np.stack(actions)
    return [Rollout(recording=recordings.get(i), actions=acted[:length, i]) for i, length in enumerate(lengths)]


def inference_time(plant: TestPlant, policy: Policy) -> float:
    """Measure the median time of one decision for one robot [us], at the start of a motion; all take as long."""
    seen = policy.preview, policy.action_scale, sees_errors(policy), find_channel(policy)
    robot, layout, observation = _waiting(plant, *seen)
    agent = policy.agent(robot, layout)
    state, times = None, []
    for k in range(TIMED):
        began = time.perf_counter()
        _, state = agent.predict(observation, state, np.array([k == 0]), True)
        times.append(time.perf_counter() - began)
    return float(np.median(times)) * 1e6


@lru_cache(maxsize=8)
def _waiting(
    plant: TestPlant, preview: int, action_scale: float, feedback: bool, channel: Channel
) -> tuple[RobotDescription, ObservationLayout, Array]:
    """Return robot, layout and observation of a plant when a motion begins, for agents with such arguments.

    The motion is a short one, as its inverse kinematics take most of the time.
    """
    short: dict[str, Any] = {"positions": [TRAIN_POSITION], "speeds": [max(SPEEDS)], "radii": [min(RADII)]}
    env = environment_for(plant, preview, action_scale, 1, feedback=feedback, channel=channel, n_threads=1, **short)
    observation, _ = env.reset(seed=0)
    core: TrackingCore = env.unwrapped.core
    env.close()
    return core.robot, core.observation_layout, observation
