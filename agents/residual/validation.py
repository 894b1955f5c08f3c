"""Validation of residual policies: path error over that of the base, on circles neither trained on nor scored.

Training circles lie at p1, with radii of 1, 3 and 5 mm at 10, 40 and 100 mm/s; the leaderboard scores these at all
named positions. Choices of design are made on the circles here, on robots drawn by a seed of their own.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode

from ffgym.agents.amortised.draws import draw_machines
from ffgym.agents.residual.actor import Actor, LinearLayer
from ffgym.agents.residual.composition import per_motor
from ffgym.agents.residual.plan import ENCODER_BITS, ENVIRONMENT
from ffgym.agents.residual.policy import ResidualPolicy
from ffgym.core.errors import FFGymError, check_whole
from ffgym.core.registration import find_spec
from ffgym.core.types import Array
from ffgym.envs import Sensing
from ffgym.robot import load_robot
from ffgym.simulation.plant import PlantDistribution

POINTS = ((1.5, 0.0, 0.6), (1.4, 0.12, 0.6), (1.6, -0.12, 0.6))
"""Centres of circles [m]: between the corners p1 to p4 of the built-in robot's work area."""
RADIUS = 0.0025
"""Radius of the circles [m]."""
SPEEDS = (0.015, 0.060)
"""Speeds of the tool [m/s]."""
SEED = 20_251_900
"""Seed of the drawn robots; trainings have seeds that SeedSequence gives, the leaderboard numbers its plants."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PolicyValidation:
    """RMS path errors [m] on the circles of one draw of robots, shape (C,)."""

    policy: Array
    base: Array

    @property
    def log_ratio(self) -> float:
        """Mean of ln(policy / base): 0 is no gain, -0.69 half of the error."""
        return float(np.mean(np.log(self.policy / self.base)))


def validate(
    policy: ResidualPolicy,
    robot: str = "irb4600_60_205",
    *,
    plants: int = 2,
    seed: int = SEED,
    effects: bool = False,
) -> PolicyValidation:
    """Run a policy and its base on all circles of the validation.

    Args:
        policy: trained or not.
        robot: nominal robot of the controller.
        plants: robots drawn for each circle.
        seed: seed of these robots.
        effects: True draws machines with physical effects in place of robots, see `ffgym.agents.amortised.draws`.

    Raises:
        FFGymError: if the robot has no such places, or stopped on its way.
    """
    check_whole("plants", plants, low=1, high=10_000)
    base = base_errors(policy.base, policy.machine, policy.action_scale, policy.preview, robot, plants, seed, effects)
    return PolicyValidation(policy=_errors(policy, robot, plants, seed, effects), base=base)


@lru_cache(maxsize=16)
def base_errors(
    base: str,
    machine: str | None,
    action_scale: float,
    preview: int,
    robot: str,
    plants: int,
    seed: int = SEED,
    effects: bool = False,
) -> Array:
    """Compute RMS distances of a base [m], with a network above it that adds nothing; computed once and kept.

    Raises:
        FFGymError: as `validate`.
    """
    silence = LinearLayer(weight=np.zeros((1, per_motor(1))), bias=np.zeros(1))
    n = load_robot(robot).n_joints
    actor = Actor(n_motors=n, layers=(silence,), activation="relu", output="clip", factored=True)
    own: dict[str, Any] = {"action_scale": action_scale, "preview": preview}
    silent = ResidualPolicy(base=base, machine=machine, actor=actor, memory=1, bound=1.0, **own)
    errors = _errors(silent, robot, plants, seed, effects)
    errors.setflags(write=False)  # every caller gets this array
    return errors


def _errors(policy: ResidualPolicy, robot: str, plants: int, seed: int, effects: bool) -> Array:
    """Run a policy on every circle, and compute the RMS distance from each [m]."""
    # one robot for each plant, point and speed, all at once
    count = plants * len(POINTS) * len(SPEEDS)
    each = [{"plant": drawn} for drawn in draw_machines(load_robot(robot), count, seed)] if effects else [{}] * count
    env: Any = gym.make_vec(
        find_spec(ENVIRONMENT),
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
        randomization=None if effects else PlantDistribution(),
    )
    # squares of the path error on the circle of each robot
    try:
        agent = policy.agent(load_robot(robot), env.unwrapped.observation_layout)
        observation, _ = env.reset(seed=seed, options={"each": each})
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
