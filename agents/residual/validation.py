"""How much of its base's path error a policy leaves, on circles of their own: neither trained on nor scored.

Training circles lie at p1, with radii of 1, 3 and 5 mm at 10, 40 and 100 mm/s; the leaderboard scores these at all
named positions. Choices of design are made on these here, on robots drawn by a seed of their own.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode

from ffgym.agents.residual.actor import Actor, Layer
from ffgym.agents.residual.composition import per_motor
from ffgym.agents.residual.plan import ENCODER_BITS, ENVIRONMENT
from ffgym.agents.residual.policy import ResidualPolicy
from ffgym.core.errors import FFGymError, check_whole
from ffgym.core.types import Array
from ffgym.envs import Sensing
from ffgym.robot import load_robot
from ffgym.simulation.plant import PlantDistribution

POINTS = ((1.5, 0.0, 0.6), (1.4, 0.12, 0.6), (1.6, -0.12, 0.6))
"""Centres of circles [m]: between the corners p1 to p4 of the built-in robot's work area."""
RADIUS = 0.0025
"""Of the circles [m]."""
SPEEDS = (0.015, 0.060)
"""Of the tool [m/s]."""
SEED = 20_251_900
"""Draws the robots; trainings have seeds that SeedSequence gives, the leaderboard numbers its plants."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Validation:
    """RMS path errors [m] on the circles of one draw of robots, shape (C,)."""

    policy: Array
    base: Array

    @property
    def log_ratio(self) -> float:
        """Mean of ln(policy / base): 0 is no gain, -0.69 half of the error."""
        return float(np.mean(np.log(self.policy / self.base)))


def validate(policy: ResidualPolicy, robot: str = "irb4600_60_205", *, plants: int = 2, seed: int = SEED) -> Validation:
    """Run a policy and its base on all circles of the validation.

    Args:
        policy: trained or not.
        robot: that the controller knows.
        plants: robots drawn for each circle.
        seed: of these robots.

    Raises:
        FFGymError: if the robot has no such places, or stopped on its way.
    """
    check_whole("plants", plants, low=1, high=10_000)
    base = base_errors(policy.base, policy.machine, policy.action_scale, policy.preview, robot, plants, seed)
    return Validation(policy=_errors(policy, robot, plants, seed), base=base)


@lru_cache(maxsize=16)
def base_errors(
    base: str, machine: str | None, action_scale: float, preview: int, robot: str, plants: int, seed: int = SEED
) -> Array:
    """RMS distances of a base [m], with a network above it that adds nothing; found once and kept.

    Raises:
        FFGymError: see `validate`.
    """
    silence = Layer(weight=np.zeros((1, per_motor(1))), bias=np.zeros(1))
    n = load_robot(robot).n_joints
    actor = Actor(n_motors=n, layers=(silence,), activation="relu", output="clip", factored=True)
    own: dict[str, Any] = {"action_scale": action_scale, "preview": preview}
    silent = ResidualPolicy(base=base, machine=machine, actor=actor, memory=1, bound=1.0, **own)
    errors = _errors(silent, robot, plants, seed)
    errors.setflags(write=False)  # everybody gets this one
    return errors


def _errors(policy: ResidualPolicy, robot: str, plants: int, seed: int) -> Array:
    """RMS distance from each circle [m]."""
    count = plants * len(POINTS) * len(SPEEDS)
    env: Any = gym.make_vec(
        ENVIRONMENT,
        num_envs=count,
        autoreset_mode=AutoresetMode.SAME_STEP,
        robot=robot,
        positions=[list(point) for point in POINTS],
        speeds=SPEEDS,
        radii=[RADIUS],
        sampling="sequence",
        action_scale=policy.action_scale,
        preview=policy.preview,
        sensing=Sensing(encoder_bits=ENCODER_BITS),
        randomization=PlantDistribution(),
    )
    try:
        agent = policy.agent(load_robot(robot), env.unwrapped.observation_layout)
        observation, _ = env.reset(seed=seed)
        state, starts = None, np.ones(count, dtype=np.bool_)
        going, squares, samples = np.ones(count, dtype=np.bool_), np.zeros(count), np.zeros(count)
        while going.any():
            action, state = agent.predict(observation, state, starts)
            observation, _, terminated, truncated, info = env.step(action)
            if np.any(terminated & going):
                raise FFGymError("A robot stopped in the validation: its motors were too far from their reference.")
            starts = terminated | truncated
            going &= ~starts  # the last sample of an episode is at rest, behind the circle
            on = going & (np.asarray(info["phase"]) == "circle")
            squares[on] += np.asarray(info["path_error"])[on] ** 2
            samples[on] += 1
    finally:
        env.close()
    return np.asarray(np.sqrt(squares / samples))
