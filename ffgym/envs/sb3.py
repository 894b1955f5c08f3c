"""The environments for stable-baselines3: a `VecEnv` around the native vector environment, on the same engine.

    from ffgym.envs.sb3 import make_sb3_env
    env = make_sb3_env("ffgym/CirclePath-v0", n_envs=16, order="one")
    model = PPO("MlpPolicy", env)

Importing this module needs stable-baselines3; nothing else in ffgym does.
"""

import time
from collections.abc import Sequence
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode

from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.registration import find_spec
from ffgym.core.types import Array, BoolArray

try:
    from stable_baselines3.common.monitor import Monitor
    from stable_baselines3.common.vec_env import VecEnv
except ImportError as error:
    raise FFGymError("ffgym.envs.sb3 needs stable-baselines3; pip install 'ffgym[rl]'.") from error


def make_sb3_env(name: str, n_envs: int = 1, *, info_keys: Sequence[str] = (), **kwargs: Any) -> "SB3VecEnv":
    """Return `n_envs` sub-environments of a registered environment for stable-baselines3.

    Args:
        name: id, e.g. 'ffgym/CirclePath-v0'.
        n_envs: number of sub-environments.
        info_keys: as for `SB3VecEnv`.
        kwargs: keyword arguments of the environment.
    """
    for own, instead in {"num_envs": "n_envs", "autoreset_mode": "nothing, it is always SameStep"}.items():
        if own in kwargs:
            raise FFGymError(f"{own} = {kwargs[own]!r} is not for make_sb3_env; give {instead}.")
    env = gym.make_vec(find_spec(name), num_envs=n_envs, autoreset_mode=AutoresetMode.SAME_STEP, **kwargs)
    return SB3VecEnv(env, info_keys=info_keys)


class SB3VecEnv(VecEnv):
    """A native vector environment (in autoreset mode SAME_STEP) with the interface of stable-baselines3.

    Infos carry `TimeLimit.truncated`, and when an episode ends `terminal_observation` and `episode` (r, l, t), as SB3's
    Monitor gives them: no Monitor is needed around it.

    Args:
        env: the vector environment.
        info_keys: entries of its info to pass on in every step, e.g. ('path_error',); none, since they cost time.
    """

    def __init__(self, env: gym.vector.VectorEnv[Array, Array, Any], *, info_keys: Sequence[str] = ()) -> None:
        if env.metadata.get("autoreset_mode") is not AutoresetMode.SAME_STEP:
            raise FFGymError(
                f"SB3VecEnv needs autoreset_mode='SameStep', got {env.metadata.get('autoreset_mode')}; make_sb3_env "
                f"chooses it."
            )
        self.env = env
        if isinstance(info_keys, str) or not isinstance(info_keys, Sequence):
            raise FFGymError(f"info_keys = {info_keys!r} must be a list, e.g. ['path_error'].")
        self._info_keys = tuple(info_keys)
        self._actions: Array | None = None
        self._began = time.perf_counter()
        self._return, self._length = np.zeros(env.num_envs), np.zeros(env.num_envs, dtype=np.int64)
        super().__init__(env.num_envs, env.single_observation_space, env.single_action_space)

    def reset(self) -> Array:
        """Begin episodes everywhere, with the seeds and options set before; returns the observations (B, D)."""
        seeds = None if all(seed is None for seed in self._seeds) else self._seeds
        options = {"each": self._options} if any(self._options) else None
        try:
            observation, info = self.env.reset(seed=seeds, options=options)  # type: ignore[arg-type]
        finally:  # refused seeds and options are dropped
            self._reset_seeds()
            self._reset_options()
        self._return[:], self._length[:] = 0.0, 0
        for key in self._info_keys:
            check_choice("info key", key, [name for name in info if not name.startswith("_")])
        self.reset_infos = [self._info_of(info, i) for i in range(self.num_envs)]
        return observation

    def step_async(self, actions: Array) -> None:
        """Keep actions (B, N) for `step_wait`."""
        self._actions = actions

    def step_wait(self) -> tuple[Array, Array, BoolArray, list[dict[str, Any]]]:
        """Step all robots; observations (B, D), rewards (B,), ends (B,) and infos."""
        if self._actions is None:
            raise FFGymError("step_wait without step_async: there are no actions.")
        observation, reward, terminated, truncated, info = self.env.step(self._actions)
        self._actions = None
        done = terminated | truncated
        self._return += reward
        self._length += 1
        # end by time, after which a learner still bootstraps the value
        infos: list[dict[str, Any]] = [self._info_of(info, i) for i in range(self.num_envs)]
        for own, cut in zip(infos, (truncated & ~terminated).tolist(), strict=True):
            own["TimeLimit.truncated"] = cut
        # statistics and last observation of the episodes that ended
        for i in np.flatnonzero(done).tolist():
            infos[i] |= self._info_of(info["final_info"], i)  # of the episode that ended, not of the new one
            infos[i]["terminal_observation"] = info["final_obs"][i]
            self.reset_infos[i] = self._info_of(info, i)
            infos[i]["episode"] = {
                "r": float(self._return[i]),
                "l": int(self._length[i]),
                "t": round(time.perf_counter() - self._began, 6),
            }
        self._return[done], self._length[done] = 0.0, 0
        return observation, reward.astype(np.float32), done, infos

    def _info_of(self, info: dict[str, Any], i: int) -> dict[str, Any]:
        return {key: info[key][i] for key in self._info_keys}

    def close(self) -> None:
        """Close the environment."""
        self.env.close()

    def get_images(self) -> Sequence[Array | None]:
        """Render pictures of all sub-environments."""
        pictures = self.env.render()
        return [None] * self.num_envs if pictures is None else list(pictures)  # type: ignore[arg-type]

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """Return an attribute of the environment; all sub-environments share it."""
        value = getattr(self.env.unwrapped if not hasattr(self.env, attr_name) else self.env, attr_name)
        return [value for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Refuse: sub-environments share one engine."""
        raise FFGymError(
            f"Cannot set {attr_name!r} of single sub-environments, they share one engine; give it to make_sb3_env, or "
            f"use set_options for the next episodes."
        )

    def env_method(self, method_name: str, *method_args: Any, indices: Any = None, **method_kwargs: Any) -> list[Any]:
        """Call a method of the vector environment once; return its result for all sub-environments."""
        chosen = list(self._get_indices(indices))
        if len(chosen) < self.num_envs:
            raise FFGymError(f"Sub-environments share one engine: call {method_name!r} for all, not for {chosen}.")
        result = self.get_attr(method_name)[0](*method_args, **method_kwargs)
        return [result for _ in chosen]

    def env_is_wrapped(self, wrapper_class: type[gym.Wrapper[Any, Any, Any, Any]], indices: Any = None) -> list[bool]:
        """Report Monitor as present, since its statistics are."""
        return [issubclass(wrapper_class, Monitor) for _ in self._get_indices(indices)]
