"""PPO of stable-baselines3 on the native vector environment, against SB3's own vector of single environments."""

import time
from collections.abc import Callable
from typing import Any

from ffgym.core.provenance import installed
from scripts.bench.environments import CIRCLES
from scripts.bench.turns import Ratio, take_turns

N_ENVS = 16
PPO_SETTINGS: dict[str, Any] = {"n_steps": 64, "batch_size": 256, "n_epochs": 4}
"""A small network learns from 1024 steps at a time, so that one measurement takes a second."""


def training_ratios(repeats: int) -> list[Ratio]:
    """Steps per second of `learn`, on one thread of torch; empty if stable-baselines3 is not installed."""
    if not (installed("stable-baselines3") and installed("torch")):
        return []
    import torch
    from stable_baselines3.common.env_util import make_vec_env

    from ffgym.envs.sb3 import make_sb3_env

    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        native, single = make_sb3_env(CIRCLES, N_ENVS), make_vec_env(CIRCLES, N_ENVS)
        ratio = take_turns(
            f"PPO, {N_ENVS} envs: ffgym.envs.sb3 / DummyVecEnv",
            learning_rate_of(native),
            learning_rate_of(single),
            repeats,
            unit="steps/s",
        )
        native.close()
        single.close()
    finally:
        torch.set_num_threads(threads)
    return [ratio]


def learning_rate_of(env: Any) -> Callable[[], float]:
    """Function that lets PPO learn for one batch of steps and returns steps of sub-environments per second."""
    from stable_baselines3 import PPO

    model = PPO("MlpPolicy", env, seed=0, device="cpu", policy_kwargs={"net_arch": [64, 64]}, **PPO_SETTINGS)
    steps = PPO_SETTINGS["n_steps"] * env.num_envs

    def rate() -> float:
        began = time.perf_counter()
        model.learn(steps, reset_num_timesteps=False)
        return steps / (time.perf_counter() - began)

    return rate
