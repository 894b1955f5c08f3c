"""Episodes as arrays: what an agent saw, did and got, and what makes each episode again."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import gymnasium as gym
import numpy as np

from ffgym.control import Agent
from ffgym.core.errors import FFGymError, check_choice, check_whole
from ffgym.core.types import Array, BoolArray
from ffgym.envs.single import TrackingEnv


@dataclass(frozen=True, kw_only=True, eq=False)
class Episode:
    """One episode of T steps, and what makes it again: reset with `seed` and `options`, then step `actions`."""

    seed: int
    options: dict[str, Any]
    task: dict[str, Any]
    """The motion that was followed, e.g. position, speed and radii."""
    fingerprint: str
    """Of the simulated physics."""
    observations: Array
    """Shape (T + 1, D); the first is that of the reset."""
    actions: Array
    """As applied, within the action space and of its type, shape (T, N)."""
    rewards: Array
    """Shape (T,)."""
    terminations: BoolArray
    """Emergency stop, shape (T,)."""
    truncations: BoolArray
    """End of the motion or of the horizon, shape (T,)."""
    infos: dict[str, Array]
    """Entries of info that were asked for, shape (T + 1, ...) each."""


def collect(
    env: gym.Env[Array, Array],
    agent: Agent | None = None,
    n_episodes: int = 1,
    seed: int = 0,
    *,
    options: Mapping[str, Any] | None = None,
    info_keys: Sequence[str] = (),
    deterministic: bool = True,
) -> list[Episode]:
    """Run whole episodes of a single environment of ffgym.

    Args:
        env: made with `gym.make`.
        agent: anything with the `predict` of stable-baselines3; None adds no torque.
        n_episodes: number of episodes.
        seed: episode k is reset with seed + k.
        options: of every reset.
        info_keys: entries of info to keep at every step, e.g. ('path_error', 'u_p').
        deterministic: passed on to `predict`.

    Raises:
        FFGymError: if an argument is not valid, or `env` is no single environment of ffgym.
    """
    if not isinstance(env.unwrapped, TrackingEnv):
        raise FFGymError(f"Episodes are collected from a single environment of ffgym, made with gym.make, got {env!r}.")
    n_episodes = check_whole("n_episodes", n_episodes, low=1)
    seed = check_whole("seed", seed, low=0)
    return [_episode(env, agent, seed + k, dict(options or {}), info_keys, deterministic) for k in range(n_episodes)]


def _episode(
    env: gym.Env[Array, Array],
    agent: Agent | None,
    seed: int,
    options: dict[str, Any],
    info_keys: Sequence[str],
    deterministic: bool,
) -> Episode:
    observation, info = env.reset(seed=seed, options=options)
    for key in info_keys:
        check_choice("info key", key, list(info))
    core = env.unwrapped.core  # type: ignore[attr-defined]
    motion = core.motions[0]
    space: Any = env.action_space
    observations, infos = [observation], [info]
    actions: list[Array] = []
    results: list[tuple[Any, bool, bool]] = []
    state, ended = None, False
    while not ended:
        action = np.zeros(space.shape, dtype=space.dtype)
        if agent is not None:
            start = np.array([not actions])
            batch, state = agent.predict(observation[None], state, start, deterministic=deterministic)
            action = np.clip(batch[0], space.low, space.high).astype(space.dtype)
        observation, reward, terminated, truncated, info = env.step(action)
        ended = terminated or truncated
        observations.append(observation)
        actions.append(action)
        results.append((reward, terminated, truncated))
        infos.append(info)
    rewards, terminations, truncations = (np.array(column) for column in zip(*results, strict=True))
    return Episode(
        seed=seed,
        options=options,
        task=motion.task,
        fingerprint=core.plant.fingerprint(),
        observations=np.stack(observations),
        actions=np.stack(actions),
        rewards=rewards,
        terminations=terminations,
        truncations=truncations,
        infos={key: np.array([info[key] for info in infos]) for key in info_keys},
    )
