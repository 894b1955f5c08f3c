"""Environments, fake agents and comparisons that the environments' tests share."""

from dataclasses import replace

import gymnasium as gym
import numpy as np
from gymnasium.vector import SyncVectorEnv

from ffgym.robot import load_robot

CIRCLE, ONE_AXIS, JOINTS = "ffgym/CirclePath-v0", "ffgym/OneAxis-v0", "ffgym/JointMotion-v0"
FAST_SERVO = replace(load_robot("one_axis"), servo=replace(load_robot("one_axis").servo, position_gain=np.array([1e3])))
OTHER_GEAR = replace(load_robot("one_axis"), drive=replace(load_robot("one_axis").drive, gear_ratio=np.array([2.0])))


class Remembering:
    """An agent with memory, as stable-baselines3's recurrent ones: its state starts anew where an episode does."""

    def __init__(self, size=0.05):
        self.size = size
        self.calls = []

    def predict(self, observation, state=None, episode_start=None, deterministic=False):
        old = np.zeros((len(observation), 1)) if state is None else state
        new = np.where(episode_start[:, None], 0.0, 0.8 * old) + 1.0 + 0.1 * np.tanh(observation[:, :1])
        call = {"observation": observation.copy(), "start": np.array(episode_start), "steps": new}
        self.calls.append(call | {"deterministic": deterministic, "state": state})
        return self.size * new, new


def actions_for(steps, n, joints=1, seed=5):
    return np.random.default_rng(seed).uniform(-1, 1, size=(steps, n, joints))


def synchronous(name, n, mode, make):
    """Gymnasium's own vector environment over single environments; `make()` gives fresh keyword arguments for each."""
    return SyncVectorEnv([lambda: gym.make(name, **make()).unwrapped for _ in range(n)], autoreset_mode=mode)


def assert_same_info(native, gymnasiums, path="info"):
    """Every key of Gymnasium's info is in ours, with the same mask, and the same values where the mask is set."""
    for key, theirs in gymnasiums.items():
        where = f"{path}[{key!r}]"
        assert key in native, where
        ours = native[key]
        if isinstance(theirs, dict):
            assert_same_info(ours, theirs, where)
        elif key.startswith("_"):
            np.testing.assert_array_equal(ours, theirs, err_msg=where)
        else:
            mask = gymnasiums[f"_{key}"]
            for i in np.flatnonzero(mask):
                np.testing.assert_array_equal(ours[i], theirs[i], err_msg=f"{where} of {i}")


def plant_state(env):
    """Bits of the engine's state."""
    return env.unwrapped.core.plant.batch.state.copy()
