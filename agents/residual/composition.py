"""Composition of a feed-forward law and a policy on top: features, memory and action, alike in training and in use.

All numbers of a motor are scaled by its own nominal friction, servo and rotor, so that one small network can serve all
motors alike, and no feature has to be normalised by statistics of the data.
"""

from dataclasses import dataclass, replace

import numpy as np

from ffgym.agents.law_agent import LawAgent
from ffgym.control import CausalLaw, ObservationLayout
from ffgym.core.errors import FFGymError, check_number, check_whole
from ffgym.core.types import Array, BoolArray
from ffgym.robot import RobotDescription

LIMIT = 10.0
"""Features are clipped to +-LIMIT."""
ERROR_UNIT = 0.1
"""Unit of the observed errors, in errors that breakaway torque causes. Chosen: at 10 mm/s friction that is 30 % off
leaves errors of some hundredths of them, which a network must distinguish from zero."""
AHEAD = (1, 2, 4, 8)
"""Samples of the reference that are seen; an action is reached at sample 1, and the last is 32 ms ahead, in which a
joint's servo has settled most of an error."""
_PER_SAMPLE = 3
"""Numbers of each remembered sample: error, speed error, residual that was added."""
_PER_AHEAD = 3
"""Numbers of each sample of the reference: direction, speed, acceleration."""


def per_motor(memory: int) -> int:
    """Count the numbers F per motor for so many samples of errors and residuals."""
    return _PER_SAMPLE * memory + _PER_AHEAD * len(AHEAD)


@dataclass(frozen=True, kw_only=True, eq=False)
class Features:
    """F numbers for each of N motors, from an observation and the memory of those before it.

    Of each remembered sample, the newest first: position error in tenths of f_s / K_p, speed error in tenths of f_s /
    K_v, both without the errors that the law below causes, and residual torque in its bound; of each sample ahead:
    tanh of the speed in Stribeck velocities, speed in f_s / f_v, acceleration in f_s / J_m.
    """

    layout: ObservationLayout
    """Layout of the observations."""
    stribeck_velocity: Array
    """Stribeck velocity of the nominal friction, motor side [rad/s], shape (N,)."""
    memory: int = 1
    """Samples M of errors and residuals that are seen, the present one included."""

    def __post_init__(self) -> None:
        check_whole("memory", self.memory, unit="samples", low=1, high=1000)
        if self.layout.preview < AHEAD[-1]:
            raise FFGymError(
                f"A residual policy reads the reference {AHEAD[-1]} samples ahead: make the environment with "
                f"preview={AHEAD[-1]} or more, not {self.layout.preview}."
            )

    @property
    def size(self) -> int:
        """Number of all features, N F."""
        return self.layout.n_joints * per_motor(self.memory)

    def sample(self, observation: Array, own: tuple[Array, Array], residual: Array) -> Array:
        """Compute the sample to remember of observations (..., D), shape (..., 3, N).

        Args:
            observation: observation of the environment.
            own: errors [rad], [rad/s], motor side, which the law below causes now, shape (..., N) each.
            residual: residual that the policy added on the way here, in [-1, 1], shape (..., N).
        """
        rows = []
        for name, asked in zip(("error", "error_rate"), own, strict=True):
            error = self._seen(observation, name) - asked / self.layout[name].scale
            rows.append(np.clip(error / ERROR_UNIT, -LIMIT, LIMIT))
        return np.stack([*rows, residual], axis=-2)

    def read(self, memory: Array, observation: Array) -> Array:
        """Compute features (..., N F): all numbers of the first motor, then those of the next."""
        past = memory.reshape(*memory.shape[:-3], _PER_SAMPLE * self.memory, memory.shape[-1])
        rows = [past]
        unit = self.layout["reference_velocity"].scale / self.stribeck_velocity  # of speeds, in Stribeck velocities
        for k in AHEAD:
            speed, acceleration = (
                self._seen(observation, f"reference_{name}_{k}") for name in ("velocity", "acceleration")
            )
            ahead = np.stack([np.tanh(unit * speed), speed, acceleration], axis=-2)
            rows.append(np.clip(ahead, -LIMIT, LIMIT))
        features = np.swapaxes(np.concatenate(rows, axis=-2), -1, -2)
        return features.reshape(*features.shape[:-2], self.size)

    def _seen(self, observation: Array, name: str) -> Array:
        """Return an entry of observations in its scale, shape (..., N)."""
        seen: Array = observation[..., self.layout[name].slice]
        return seen


@dataclass(frozen=True, kw_only=True, eq=False)
class CompositionMemory:
    """Memory from one decision to the next, in B sub-environments."""

    law: Array
    """Memory of the law below, shape (B, K)."""
    own: tuple[Array, Array]
    """Errors [rad], [rad/s] that the law causes at the next sample, motor side, shape (B, N) each."""
    past: Array
    """Samples of the features, shape (B, M, 3, N)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PolicyInput:
    """Input of a policy's decision: features, action of the law below, memory."""

    features: Array
    """Features, shape (B, N F)."""
    base: Array
    """Action of the law below, shape (B, N)."""
    memory: CompositionMemory


@dataclass(frozen=True, kw_only=True, eq=False)
class Composition:
    """A law and the features of a policy above it, in one environment."""

    base: LawAgent | None
    """The law below; None adds nothing."""
    features: Features
    share: Array
    """Action that a residual of 1 adds, shape (N,)."""
    averaged: bool
    """True counts errors from `CausalLaw.own_error`, False from `CausalLaw.instant_error`."""

    @classmethod
    def over(
        cls,
        law: CausalLaw | None,
        robot: RobotDescription,
        layout: ObservationLayout,
        *,
        memory: int,
        bound: float,
        averaged: bool = True,
    ) -> "Composition":
        """Compose a law and features for an environment.

        Args:
            law: the base; None adds nothing.
            robot: nominal description, on which the controller relies.
            layout: layout of the environment's observations.
            memory: samples of errors and residuals that the policy sees.
            bound: largest residual torque, in units of each joint's breakaway torque f_s.
            averaged: False for a policy that was trained on errors less `CausalLaw.instant_error`.

        Raises:
            FFGymError: if law or features need more of the reference than is observed, or a number is out of range.
        """
        check_number("bound of the residual", bound, unit="breakaway torques", low=0.0, open_low=True)
        dt = robot.servo.control_dt
        return cls(
            base=None if law is None else LawAgent(law=law, layout=layout, control_dt=dt),
            features=Features(layout=layout, stribeck_velocity=robot.friction.stribeck_velocity, memory=memory),
            share=bound * robot.friction.static / layout["added_torque"].scale,
            averaged=averaged,
        )

    def begin(self, observation: Array) -> PolicyInput:
        """Compute the input when episodes begin with observations (B, D)."""
        still = np.zeros((len(observation), self.features.layout.n_joints))
        sample = self.features.sample(observation, (still, still), still)
        law = np.zeros((len(observation), 0))
        if self.base is not None:
            law = self.base.law.initial_memory(self.base.window(observation))
        past = np.repeat(sample[:, None], self.features.memory, axis=1)  # the first sample stands for those before it
        memory = CompositionMemory(law=law, own=(still, still), past=past)
        return self._seen(memory, observation)

    def follow(self, memory: CompositionMemory, observation: Array, residual: Array) -> PolicyInput:
        """Compute the input after residuals (B, N) in [-1, 1] led to observations (B, D)."""
        sample = self.features.sample(observation, memory.own, residual)
        past = np.concatenate([sample[:, None], memory.past[:, : self.features.memory - 1]], axis=1)  # newest in front
        return self._seen(replace(memory, past=past), observation)

    def action(self, seen: PolicyInput, residual: Array) -> Array:
        """Add law and residual to actions (B, N), clipped to [-1, 1]."""
        return np.clip(seen.base + self.share * residual, -1.0, 1.0)

    def _seen(self, memory: CompositionMemory, observation: Array) -> PolicyInput:
        features = self.features.read(memory.past, observation)
        if self.base is None:
            return PolicyInput(features=features, base=np.zeros((len(observation), len(self.share))), memory=memory)
        action, law = self.base.predict(observation, memory.law)
        known = replace(memory, law=law, own=self._own_error(self.base, memory.law, observation))
        return PolicyInput(features=features, base=action, memory=known)

    def _own_error(self, base: LawAgent, memory: Array, observation: Array) -> tuple[Array, Array]:
        """Compute the errors that the law causes at the next sample, from its memory before the step there."""
        if self.averaged:
            return base.law.own_error(memory, base.window(observation))
        return base.law.instant_error(memory)


def take_where(where: BoolArray, fresh: PolicyInput, old: PolicyInput) -> PolicyInput:
    """Take `fresh` in the sub-environments where an episode has begun, `old` elsewhere."""

    def pick(new: Array, kept: Array) -> Array:
        return np.where(where.reshape(-1, *[1] * (kept.ndim - 1)), new, kept)

    a, b = fresh.memory, old.memory
    memory = CompositionMemory(
        law=pick(a.law, b.law), own=(pick(a.own[0], b.own[0]), pick(a.own[1], b.own[1])), past=pick(a.past, b.past)
    )
    return PolicyInput(features=pick(fresh.features, old.features), base=pick(fresh.base, old.base), memory=memory)
