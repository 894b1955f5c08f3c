"""Episodes as a Minari data set, the format of offline reinforcement learning: collect, then write.

    from ffgym.envs.minari import collect, write_dataset
    env = gym.make("ffgym/CirclePath-v0", horizon=500)
    dataset = write_dataset("ffgym/circle-path/zero-v0", env, collect(env, n_episodes=10))

Collecting needs ffgym alone; only writing needs Minari.
"""

import re
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import gymnasium as gym
import numpy as np

from ffgym.control import Agent
from ffgym.core.errors import FFGymError, check_choice, check_whole
from ffgym.core.provenance import versions
from ffgym.core.types import Array, BoolArray
from ffgym.envs.single import TrackingEnv

_ID = re.compile(r"([-_\w][-_\w/]*/)?[-_\w]+-v\d+")


@dataclass(frozen=True, kw_only=True, eq=False)
class Episode:
    """One episode of T steps; it is repeated by a reset with `seed` and `options` and steps of `actions`."""

    seed: int
    options: dict[str, Any]
    task: dict[str, Any]
    """The motion that was followed, e.g. position, speed and radii."""
    fingerprint: str
    """Fingerprint of the simulated physics."""
    observations: Array
    """Shape (T + 1, D); the first is that of the reset."""
    actions: Array
    """Applied actions, within the action space and of its type, shape (T, N)."""
    rewards: Array
    """Shape (T,)."""
    terminations: BoolArray
    """Emergency stop, shape (T,)."""
    truncations: BoolArray
    """End of the motion or of the horizon, shape (T,)."""
    infos: dict[str, Array]
    """Chosen entries of info, shape (T + 1, ...) each."""


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
        options: options of every reset.
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
    """Run one episode to its end."""
    observation, info = env.reset(seed=seed, options=options)
    for key in info_keys:
        check_choice("info key", key, list(info))
    core = env.unwrapped.core  # type: ignore[attr-defined]
    motion = core.motions[0]
    space: Any = env.action_space
    # actions within the space and of its type, as they are applied
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
        # transition: observations and infos have one entry more than actions
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


def write_dataset(
    dataset_id: str, env: gym.Env[Array, Array], episodes: Sequence[Episode], *, recoverable: bool = True, **about: Any
) -> Any:
    """Write episodes into the folder MINARI_DATASETS_PATH (or Minari's own), and return the `MinariDataset`.

    Metadata of an episode are its seed, options, task and physics fingerprint; those of the data set are the versions
    of all packages behind it, and `requirements` by which Minari warns when the environment is recovered with others.

    Args:
        dataset_id: e.g. 'ffgym/circle-path/zero-v0'.
        env: environment of the episodes.
        episodes: episodes from `collect`.
        recoverable: keep the arguments of the environment, so that `dataset.recover_environment()` makes it again.
        about: arguments passed on to Minari: algorithm_name, author, author_email, code_permalink, description, ...

    Raises:
        FFGymError: if Minari is not installed, the id is not valid or taken, or something cannot be written.
    """
    try:
        import minari
        from minari.data_collector import EpisodeBuffer
    except ImportError as error:
        raise FFGymError("Writing a data set needs Minari; pip install 'ffgym[minari]'.") from error
    _check_dataset(dataset_id, env, episodes, recoverable)
    versions_now = versions()
    about = {
        "description": f"{len(episodes)} episodes of {env.spec.id if env.spec else env}.",
        "requirements": [f"{name}=={versions_now[name]}" for name in ("ffgym", "mujoco")],
    } | about
    # episodes as Minari takes them
    buffers = [
        EpisodeBuffer(
            seed=episode.seed,
            options=episode.options or None,
            observations=episode.observations,
            actions=episode.actions,
            rewards=episode.rewards,
            terminations=episode.terminations,
            truncations=episode.truncations,
            infos=episode.infos or None,
        )
        for episode in episodes
    ]
    # write, without warnings of entries that are left out on purpose
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=r"`\w+` is set to None", category=UserWarning)  # they are optional
        warnings.filterwarnings("ignore", message="env_spec is None", category=UserWarning)  # as was asked for
        try:
            dataset = minari.create_dataset_from_buffers(
                dataset_id,
                buffers,
                env=env if recoverable else None,
                observation_space=env.observation_space,
                action_space=env.action_space,
                **about,
            )
        except ValueError as error:
            raise FFGymError(f"Minari refuses data set {dataset_id!r}: {error}") from error
    # metadata by which episodes are repeated
    dataset.storage.update_metadata({"versions": versions_now})
    dataset.storage.update_episode_metadata(
        [  # Minari reads 'task/speed' as an entry of the dict 'task'
            {f"task/{name}": value for name, value in episode.task.items()}
            | {"physics_fingerprint": episode.fingerprint}
            for episode in episodes
        ]
    )
    return dataset


def _check_dataset(dataset_id: str, env: gym.Env[Array, Array], episodes: Sequence[Episode], recoverable: bool) -> None:
    """Refuse arguments that Minari would refuse in the middle of writing."""
    if not _ID.fullmatch(dataset_id):
        raise FFGymError(f"dataset_id = {dataset_id!r} must be namespace/name-v0 or name-v0, e.g. 'ffgym/circle-v0'.")
    if not episodes:
        raise FFGymError("There are no episodes to write; collect some first.")
    for name, value in episodes[0].options.items():
        if np.asarray(value).dtype.kind not in "biufU":
            raise FFGymError(
                f"Reset option {name!r} = {value!r} cannot be written; give it to the environment instead, and write "
                f"with recoverable=False."
            )
    if not recoverable:
        return
    if env.spec is None:
        raise FFGymError(f"{env} has no spec, so it could not be made again; make it with gym.make.")
    for name, value in env.spec.kwargs.items():
        if not _is_plain(value):
            raise FFGymError(
                f"The argument {name} = {value!r} of the environment has no written form. Use numbers and text only, "
                f"or pass recoverable=False for a data set without its environment."
            )


def _is_plain(value: Any) -> bool:
    """Check that JSON preserves a value, but for tuples; dataclasses would silently come back as dicts."""
    if isinstance(value, list | tuple):
        return all(_is_plain(item) for item in value)
    return value is None or isinstance(value, str | bool | int | float)
