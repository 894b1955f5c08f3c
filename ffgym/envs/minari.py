"""Episodes as a Minari data set, the format of offline reinforcement learning: collect, then write.

    from ffgym.envs.minari import collect, write_dataset
    env = gym.make("ffgym/CirclePath-v0", horizon=500)
    dataset = write_dataset("ffgym/circle-path/zero-v0", env, collect(env, n_episodes=10))

Collecting needs nothing but ffgym; writing needs Minari, which nothing else in ffgym does.
"""

import re
import warnings
from collections.abc import Sequence
from typing import Any

import gymnasium as gym
import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.provenance import versions
from ffgym.core.types import Array
from ffgym.envs.episodes import Episode as Episode
from ffgym.envs.episodes import collect as collect

_ID = re.compile(r"([-_\w][-_\w/]*/)?[-_\w]+-v\d+")


def write_dataset(
    dataset_id: str, env: gym.Env[Array, Array], episodes: Sequence[Episode], *, recoverable: bool = True, **about: Any
) -> Any:
    """Write episodes into the folder MINARI_DATASETS_PATH (or Minari's own), and return the `MinariDataset`.

    Metadata of an episode are its seed, options, task and physics fingerprint; those of the data set are the versions
    of all that made it, and `requirements` by which Minari warns when the environment is recovered with others.

    Args:
        dataset_id: e.g. 'ffgym/circle-path/zero-v0'.
        env: where the episodes come from.
        episodes: from `collect`.
        recoverable: keep the arguments of the environment, so that `dataset.recover_environment()` makes it again.
        about: passed on to Minari: algorithm_name, author, author_email, code_permalink, description, ...

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
    dataset.storage.update_metadata({"versions": versions_now})
    dataset.storage.update_episode_metadata([_metadata(episode) for episode in episodes])
    return dataset


def _metadata(episode: Episode) -> dict[str, Any]:
    """Metadata of an episode; Minari reads 'task/speed' as an entry of the dict 'task'."""
    return {f"task/{name}": value for name, value in episode.task.items()} | {
        "physics_fingerprint": episode.fingerprint
    }


def _check_dataset(dataset_id: str, env: gym.Env[Array, Array], episodes: Sequence[Episode], recoverable: bool) -> None:
    """Refuse what Minari would refuse in the middle of writing."""
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
                f"or pass recoverable=False for a data set that does not know its environment."
            )


def _is_plain(value: Any) -> bool:
    """Whether JSON gives a value back as it was, but for tuples; dataclasses would silently come back as dicts."""
    if isinstance(value, list | tuple):
        return all(_is_plain(item) for item in value)
    return value is None or isinstance(value, str | bool | int | float)
