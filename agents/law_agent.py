"""Any causal feed-forward law as an agent with stable-baselines3's `predict`, and as a policy of the leaderboard."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ffgym.control import Agent, CausalLaw, FeedForwardLaw, ObservationLayout, Window
from ffgym.control.corrections import next_correction
from ffgym.control.observation import Channel
from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.robot import RobotDescription
from ffgym.robot.parts import Servo


@dataclass(frozen=True, kw_only=True, eq=False)
class LawAgent:
    """A law that acts step by step, in any number of sub-environments; its memory is the agent's state."""

    law: CausalLaw
    layout: ObservationLayout
    """Layout of the environment it acts in; observations may be longer, e.g. with a history behind the newest."""
    control_dt: float
    """Time between samples [s]."""

    def __post_init__(self) -> None:
        if not isinstance(self.law, CausalLaw):
            raise FFGymError(
                f"law = {self.law!r} must be a law that runs sample by sample, see ffgym.control.CausalLaw."
            )
        if self.layout.preview < self.law.preview:
            raise FFGymError(
                f"{self.law.name} reads the reference {self.law.preview} samples ahead: make the environment with "
                f"preview={self.law.preview} or more, not {self.layout.preview}."
            )
        if self.law.n_joints != self.layout.n_joints:
            raise FFGymError(
                f"{self.law.name} for {self.law.n_joints} joints does not fit an environment with "
                f"{self.layout.n_joints} motors."
            )

    @classmethod
    def for_env(cls, law: CausalLaw, env: Any) -> "LawAgent":
        """Return the agent for an environment of ffgym: single, vector, or stable-baselines3's.

        Raises:
            FFGymError: if the environment is another one, normalises observations, decides less often than the
                reference is sampled, or shows less of it than the law needs.
        """
        layout, dt = acting_in(env)
        return cls(law=law, layout=layout, control_dt=dt)

    def predict(
        self,
        observation: Array,
        state: Any = None,
        episode_start: Any = None,
        deterministic: bool = True,
    ) -> tuple[Array, Any]:
        """Compute actions (..., N) for observations (..., D), and the state for the next call, shape (..., M).

        Args:
            observation: one observation, or a batch of them.
            state: state that the last call returned, None at first.
            episode_start: True where an episode begins, shape (...,); None is nowhere.
            deterministic: without effect, nothing is random.

        Raises:
            FFGymError: if observations are of another environment, or the state is of another batch.
        """
        observation = np.asarray(observation)
        if observation.shape[-1:] < (self.layout.size,):
            raise FFGymError(
                f"Observations must have {self.layout.size} numbers each, as those of the environment that this agent "
                f"was made for, got shape {observation.shape}."
            )
        window = self.window(observation)
        memory = self._acting.initial_memory(window) if state is None else np.asarray(state, dtype=np.float64)
        if memory.shape[:-1] != observation.shape[:-1]:
            raise FFGymError(
                f"The state of shape {memory.shape} is not what predict returned for observations of shape "
                f"{observation.shape}; give None where a batch begins."
            )
        if state is not None and episode_start is not None and np.any(episode_start):
            fresh = np.asarray(episode_start, dtype=np.bool_)[..., None]
            memory = np.where(fresh, self._acting.initial_memory(window), memory)
        added, memory = self._acting.step(memory, window)
        return added / self.layout.action_size, memory

    @property
    def _acting(self) -> "CausalLaw | CorrectingLaw":
        """Law whose steps are what is added to torques or set-points."""
        return self.law if self.layout.channel == "torque" else CorrectingLaw(self.law, self.layout.servo)

    def window(self, observation: Array) -> Window:
        """Read the reference from observations (..., D)."""

        def read(name: str) -> Array:
            steps = range(self.law.preview + 1)
            return np.stack([self.layout.read(observation, name, ahead_by=k) for k in steps], axis=-2)

        return Window(
            q=read("reference_position"),
            motor_dq=read("reference_velocity"),
            motor_ddq=read("reference_acceleration"),
            dt=self.control_dt,
        )


@dataclass(frozen=True, eq=False)
class CorrectingLaw:
    """A law that acts through corrections of set-points, by which a servo gives its torque."""

    law: CausalLaw
    servo: Servo

    def initial_memory(self, window: Window) -> Array:
        """Return the memory when a motion begins: torque, correction and its integral, all zero, then the law's."""
        own = self.law.initial_memory(window)
        return np.concatenate([np.zeros((*own.shape[:-1], 3 * self.law.n_joints)), own], axis=-1)

    def step(self, memory: Array, window: Window) -> tuple[Array, Array]:
        """Return the correction at sample 1 of the window, motor side [rad], (..., N), and the new memory, (..., M)."""
        n = self.law.n_joints
        before, correction, integral = (memory[..., i * n : (i + 1) * n] for i in range(3))
        torque, own = self.law.step(memory[..., 3 * n :], window)
        correction, integral = next_correction(self.servo, before, torque, correction, integral)
        return correction, np.concatenate([torque, correction, integral, own], axis=-1)


def acting_in(env: Any) -> tuple[ObservationLayout, float]:
    """Return the layout of the observations of an environment of ffgym, and its control step [s].

    Raises:
        FFGymError: if the environment is another one, normalises observations, or decides less often than the
            reference is sampled.
    """
    if getattr(env, "norm_obs", False):
        raise FFGymError("A law reads physical values: leave out VecNormalize, or give it norm_obs=False.")
    names = ("observation_layout", "control_dt", "decision_dt")
    try:
        layout, dt, decision_dt = (find_attribute(env, name) for name in names)
    except AttributeError as error:
        raise FFGymError(f"{env} is not made by gym.make, gym.make_vec or make_sb3_env with an id of ffgym.") from error
    if decision_dt != dt:
        raise FFGymError(
            f"A law acts at every sample of {dt} s, this environment decides every {decision_dt} s; leave out Hold, or "
            f"put ResidualAction(law) below it."
        )
    return layout, float(dt)


def find_attribute(env: Any, name: str) -> Any:
    """Return an attribute of an environment below its wrappers: single, vector, or stable-baselines3's."""
    is_sb3 = hasattr(env, "get_attr") and not hasattr(env, "single_action_space")
    return env.get_attr(name)[0] if is_sb3 else getattr(env.unwrapped, name)


ACTION_SCALE = 200.0
"""Torque of an action of 1 for laws, in breakaway torques. Elastic feed-forward needs 102 on the fastest circles of the
nominal robot (`ffgym.envs.settings`); chosen: twice that, as identified machines may be softer."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LawPolicy:
    """Policy (`ffgym.control.Policy`) that runs a causal law."""

    make: Callable[[RobotDescription], FeedForwardLaw]
    preview: int
    action_scale: float = ACTION_SCALE
    channel: Channel = "torque"
    """Channel that the law acts through; 'setpoint' corrects the set-points so that the servo gives its torque."""
    feedback: bool = field(default=False, init=False)
    """False, as a law reads the reference alone."""

    def agent(self, robot: RobotDescription, layout: ObservationLayout) -> Agent:
        """Make the agent of a robot, see `ffgym.control.Policy`.

        Raises:
            FFGymError: if the law does not fit the robot.
        """
        return LawAgent(law=causal(self.make(robot)), layout=layout, control_dt=robot.servo.control_dt)


def causal(law: FeedForwardLaw) -> CausalLaw:
    """Return the law if it runs sample by sample.

    Raises:
        FFGymError: if it does not.
    """
    if not isinstance(law, CausalLaw):
        raise FFGymError(f"Law {law.name!r} does not run sample by sample, so that it cannot act on observations.")
    return law
