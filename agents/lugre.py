"""LuGre friction compensation as an agent: the torque that the friction model gives at the reference speed.

Idea and source: thesis 4.1 (static) and 4.2 (dynamic); the laws are those of `ffgym.control`, which compute a whole
motion at once. An agent takes one step at a time: from the observation at t[k] it reads the reference speed now and at
t[k + 1] (the environment's `preview` must be at least 1), and returns the torque that is to be reached at t[k + 1]. The
bristle deflection of the dynamic model is the agent's state, relaxed when an episode begins.

Run it:

    env = make_sb3_env("ffgym/CirclePath-v0", n_envs=12, sampling="sequence", action_scale=8)
    evaluate_policy(LuGreAgent.for_env(DynamicLuGreExact(robot.friction), env), env, n_eval_episodes=12)

Departure from the source: none but the clipping of actions; with the default `action_scale` of 2.5 breakaway torques
the peaks of the dynamic model are cut on circles faster than 10 mm/s.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ffgym.control import DynamicLuGre, StaticLuGre
from ffgym.envs import ObservationLayout
from ffgym.errors import FFGymError
from ffgym.types import Array


@dataclass(frozen=True, kw_only=True, eq=False)
class LuGreAgent:
    """A static or dynamic LuGre law that acts step by step, in any number of sub-environments."""

    law: StaticLuGre | DynamicLuGre
    layout: ObservationLayout
    """Of the environment it acts in; observations may be longer, e.g. with a history behind the newest."""
    control_dt: float
    """Time between samples [s]."""

    def __post_init__(self) -> None:
        if not isinstance(self.law, StaticLuGre | DynamicLuGre):
            raise FFGymError(f"law = {self.law!r} must be a StaticLuGre or a DynamicLuGre of ffgym.control.")
        if self.layout.preview < 1:
            raise FFGymError("LuGre needs the next reference speed: make the environment with preview=1 or more.")
        if self.law.friction.n_joints != self.layout.n_joints:
            raise FFGymError(
                f"Friction parameters for {self.law.friction.n_joints} joints do not fit an environment with "
                f"{self.layout.n_joints} motors."
            )

    @classmethod
    def for_env(cls, law: StaticLuGre | DynamicLuGre, env: Any) -> "LuGreAgent":
        """Return the agent for an environment of ffgym: single, vector, or stable-baselines3's.

        Raises:
            FFGymError: if the environment is another one, normalises observations, or decides less often than the
                reference is sampled.
        """
        if getattr(env, "norm_obs", False):
            raise FFGymError("LuGre reads physical values: leave out VecNormalize, or give it norm_obs=False.")
        names = ("observation_layout", "control_dt", "decision_dt")
        is_sb3 = hasattr(env, "get_attr") and not hasattr(env, "single_action_space")
        try:
            layout, dt, decision_dt = (env.get_attr(n)[0] if is_sb3 else getattr(env.unwrapped, n) for n in names)
        except AttributeError as error:
            raise FFGymError(
                f"{env} is not made by gym.make, gym.make_vec or make_sb3_env with an id of ffgym."
            ) from error
        if decision_dt != dt:
            raise FFGymError(
                f"LuGre acts at every sample of {dt} s, this environment decides every {decision_dt} s; leave out "
                f"Hold, or put Residual(law) below it."
            )
        return cls(law=law, layout=layout, control_dt=dt)

    def predict(
        self,
        observation: Array,
        state: Any = None,
        episode_start: Any = None,
        deterministic: bool = True,
    ) -> tuple[Array, Any]:
        """Actions for observations (..., D), shape (..., N), and the bristle deflections [rad] for the next call.

        Args:
            observation: one observation, or a batch of them.
            state: bristle deflections from the last call, None at first.
            episode_start: True where an episode begins, shape (...,); None is nowhere.
            deterministic: without effect, nothing is random.
        """
        next_dq = self.layout.read(observation, "reference_velocity", ahead_by=1)
        scale = self.layout["added_torque"].scale
        if isinstance(self.law, StaticLuGre):
            return self.law.at_speed(next_dq) / scale, None
        memory = np.broadcast_to(self.law.initial_memory(), next_dq.shape) if state is None else state
        if episode_start is not None:
            fresh = np.asarray(episode_start, dtype=np.bool_)[..., None]
            memory = np.where(fresh, self.law.initial_memory(), memory)
        dq = self.layout.read(observation, "reference_velocity")
        torque, memory = self.law.step(memory, dq, next_dq, self.control_dt)
        return torque / scale, memory
