"""What a decision of each agent costs, against a step of the environment it decides for."""

import time
from collections.abc import Callable, Sequence
from typing import Any

import gymnasium as gym
import numpy as np

from ffgym.agents import LawAgent
from ffgym.agents.catalogue import CATALOGUE, Setting, law_named
from ffgym.control import CausalLaw
from ffgym.core.errors import FFGymError
from ffgym.robot import load_robot
from ffgym.studies import sine_references
from scripts.bench.turns import Ratio, take_turns

ONE_AXIS = "ffgym/OneAxis-v0"
"""Learning families are trained in seconds on it; the law of a robot costs as much, but for its joints."""
FREQUENCY = 1.0
"""Of the sine [Hz]; long enough for the decisions that are timed."""
DECISIONS = 100
"""In one measurement: they take 0.01 s to 0.1 s."""


def decision_ratios(sizes: Sequence[int], repeats: int) -> list[Ratio]:
    """Decisions per second of every agent that one axis has a use for, against steps per second of the environment."""
    robot = load_robot("one_axis")
    setting = Setting.of(robot, references=[sine_references(robot)[FREQUENCY]])
    ratios = []
    for name, entry in CATALOGUE.items():
        if name == "none" or entry.needs_arm:
            continue
        try:
            law = law_named(name, setting)
        except FFGymError as error:  # a library that this installation lacks
            print(f"{name}: left out: {error}")
            continue
        assert isinstance(law, CausalLaw)  # all but `none` are
        ratios += [_ratio(law, size, repeats) for size in sizes]
    return ratios


def _ratio(law: CausalLaw, size: int, repeats: int) -> Ratio:
    env = gym.make_vec(ONE_AXIS, num_envs=size, frequencies=[FREQUENCY], preview=law.preview)
    title = f"{law.name} / environment, {size} robot{'s' if size > 1 else ''}"
    ratio = take_turns(title, _deciding(law, env), _stepping(env), repeats, unit="steps/s")
    env.close()
    return ratio


def _deciding(law: CausalLaw, env: Any) -> Callable[[], float]:
    agent = LawAgent.for_env(law, env)
    observations = _first_observations(env)

    def rate() -> float:
        memory = None
        began = time.perf_counter()
        for observation in observations:
            _, memory = agent.predict(observation, memory)
        return DECISIONS / (time.perf_counter() - began)

    return rate


def _first_observations(env: Any) -> list[Any]:
    observation, _ = env.reset(seed=0)
    seen = []
    for _ in range(DECISIONS):
        seen.append(observation)
        observation = env.step(np.zeros(env.action_space.shape))[0]
    return seen


def _stepping(env: Any) -> Callable[[], float]:
    action = np.zeros(env.action_space.shape)

    def rate() -> float:
        env.reset(seed=0)
        began = time.perf_counter()
        for _ in range(DECISIONS):
            env.step(action)
        return DECISIONS / (time.perf_counter() - began)

    return rate
