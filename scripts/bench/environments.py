"""The vector environments against the bare engine, and against Gymnasium's vectors of single environments."""

import time
from typing import Any

import gymnasium as gym
import numpy as np
from mujoco import batch

from scripts.bench.turns import Amount, Ratio, take_turns

CIRCLES = "ffgym/CirclePath-v0"
BLOCK = 0.15
"""Time of one measurement [s]: short enough that the next one sees the same machine, long beside the clock."""


class Stepped:
    """A vector environment that is stepped with random actions made beforehand."""

    def __init__(self, name: str, n: int, **arguments: Any) -> None:
        self.env = gym.make_vec(name, num_envs=n, **arguments)
        self.env.reset(seed=0)
        shape = (64, *(self.env.action_space.shape or ()))
        self._actions = np.random.default_rng(0).uniform(-1, 1, size=shape).astype(np.float32)
        self._n, self._steps = n, 1
        self._steps = max(1, min(len(self._actions), int(BLOCK * self.rate() / n)))

    def rate(self) -> float:
        """Steps of sub-environments per second."""
        began = time.perf_counter()
        for action in self._actions[: self._steps]:
            self.env.step(action)
        return self._n * self._steps / (time.perf_counter() - began)


class Bare:
    """`mujoco.batch` alone: model, threads, physics steps and states of an environment, whose robots it moves on."""

    def __init__(self, env: gym.vector.VectorEnv[Any, Any, Any]) -> None:
        self._plant = env.unwrapped.core.plant  # type: ignore[attr-defined]
        own = self._plant.batch
        self._engine = batch.Batch(self._plant.model, nsim=own.nsim, nthread=own.nthread)
        self._steps = 1
        self._steps = max(1, min(256, int(BLOCK * self.rate() / own.nsim)))

    def rate(self) -> float:
        """Control steps per second, from the environment's present state with its present set-points held."""
        self._engine.state[:] = self._plant.batch.state
        began = time.perf_counter()
        for _ in range(self._steps):
            self._engine.step(nstep=self._plant.n_substeps)
        return self._engine.nsim * self._steps / (time.perf_counter() - began)


def against_the_engine(repeats: int, threads: int) -> list[Ratio]:
    """Each environment against the bare engine; all of its steps counted, also those that begin episodes."""
    cases = [(CIRCLES, n) for n in (64, 1, 16, 256)] + [("ffgym/OneAxis-v0", 64), ("ffgym/JointMotion-v0", 64)]
    ratios = []
    for name, n in cases:
        stepped = Stepped(name, n, n_threads=threads)
        ratios.append(
            take_turns(
                f"{name}, {n} / bare engine",
                stepped.rate,
                Bare(stepped.env).rate,
                repeats,
                unit="steps/s",
                wanted=0.85 if (name, n) == (CIRCLES, 64) else None,
            )
        )
        stepped.env.close()
    return ratios


def against_vectors_of_single_ones(repeats: int, threads: int, n: int = 16) -> list[Ratio]:
    """The native vector environment against Gymnasium's, one after the other and in a process each."""
    ratios = []
    for mode, arguments in {
        "sync": {},
        "async": {"vector_kwargs": {"context": "spawn"}},  # the engine's threads do not survive a fork
    }.items():
        native = Stepped(CIRCLES, n, n_threads=threads)
        other = Stepped(CIRCLES, n, vectorization_mode=mode, **arguments)
        ratios.append(take_turns(f"{CIRCLES}, {n} / {mode} vector", native.rate, other.rate, repeats, unit="steps/s"))
        native.env.close()
        other.env.close()
    return ratios


def beginnings(threads: int, n: int = 64) -> list[Amount]:
    """Time that one sub-environment needs to begin an episode: at first, and with the motion known."""
    amounts = []
    for name in (CIRCLES, "ffgym/JointMotion-v0"):
        env = gym.make_vec(name, num_envs=n, n_threads=threads)
        times = []
        for seed in range(6):
            began = time.perf_counter()
            env.reset(seed=seed)
            times.append((time.perf_counter() - began) / n * 1e3)
        amounts.append(Amount(f"{name}, reset of one of {n}, the first", times[0], "ms"))
        amounts.append(Amount(f"{name}, reset of one of {n}, later", float(np.median(times[1:])), "ms"))
        env.close()
    return amounts
