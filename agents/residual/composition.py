"""A policy on top of a feed-forward law: what both see, remember and add, the same in training and in use."""

from dataclasses import dataclass, replace

import numpy as np

from ffgym.agents.common.law_agent import LawAgent
from ffgym.agents.residual.features import Features
from ffgym.control import CausalLaw, ObservationLayout
from ffgym.core.errors import check_number
from ffgym.core.types import Array, BoolArray
from ffgym.robot import RobotDescription


@dataclass(frozen=True, kw_only=True, eq=False)
class Memory:
    """What is remembered from one decision to the next, in B sub-environments."""

    law: Array
    """Of the law below, shape (B, K)."""
    own: tuple[Array, Array]
    """Errors [rad], [rad/s] that the law asks for at the next sample, motor side, shape (B, N) each."""
    past: Array
    """Samples of the features, shape (B, M, 3, N)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Seen:
    """What is known when a policy decides."""

    features: Array
    """Shape (B, N F)."""
    base: Array
    """Action of the law below, shape (B, N)."""
    memory: Memory


@dataclass(frozen=True, kw_only=True, eq=False)
class Composition:
    """A law and the features of a policy above it, in one environment."""

    base: LawAgent | None
    """The law below; None adds nothing."""
    features: Features
    share: Array
    """Action that a residual of 1 adds, shape (N,)."""

    @classmethod
    def over(
        cls,
        law: CausalLaw | None,
        robot: RobotDescription,
        layout: ObservationLayout,
        *,
        memory: int,
        bound: float,
    ) -> "Composition":
        """A composition for an environment.

        Args:
            law: the base.
            robot: what the controller knows.
            layout: of the environment's observations.
            memory: samples of errors and residuals that the policy sees.
            bound: largest residual torque, in units of each joint's breakaway torque f_s.

        Raises:
            FFGymError: if law or features need more of the reference than is observed, or a number is out of range.
        """
        check_number("bound of the residual", bound, unit="breakaway torques", low=0.0, open_low=True)
        dt = robot.servo.control_dt
        return cls(
            base=None if law is None else LawAgent(law=law, layout=layout, control_dt=dt),
            features=Features.of(robot, layout, memory),
            share=bound * robot.friction.static / layout["added_torque"].scale,
        )

    def begin(self, observation: Array) -> Seen:
        """What is known when episodes begin with observations (B, D)."""
        still = np.zeros((len(observation), self.features.layout.n_joints))
        sample = self.features.sample(observation, (still, still), still)
        law = np.zeros((len(observation), 0))
        if self.base is not None:
            law = self.base.law.initial_memory(self.base.window(observation))
        memory = Memory(law=law, own=(still, still), past=self.features.begin(sample))
        return self._seen(memory, observation)

    def follow(self, memory: Memory, observation: Array, residual: Array) -> Seen:
        """What is known after residuals (B, N) in [-1, 1] led to observations (B, D)."""
        sample = self.features.sample(observation, memory.own, residual)
        return self._seen(replace(memory, past=self.features.remember(memory.past, sample)), observation)

    def action(self, seen: Seen, residual: Array) -> Array:
        """Actions of both together, shape (B, N), within [-1, 1]."""
        return np.clip(seen.base + self.share * residual, -1.0, 1.0)

    def _seen(self, memory: Memory, observation: Array) -> Seen:
        features = self.features.read(memory.past, observation)
        if self.base is None:
            return Seen(features=features, base=np.zeros((len(observation), len(self.share))), memory=memory)
        action, law = self.base.predict(observation, memory.law)
        known = replace(memory, law=law, own=self.base.law.own_error(memory.law))
        return Seen(features=features, base=action, memory=known)


def chosen(where: BoolArray, fresh: Seen, old: Seen) -> Seen:
    """`fresh` in the sub-environments where an episode has begun, `old` elsewhere."""

    def pick(new: Array, kept: Array) -> Array:
        return np.where(where.reshape(-1, *[1] * (kept.ndim - 1)), new, kept)

    def both(new: tuple[Array, Array], kept: tuple[Array, Array]) -> tuple[Array, Array]:
        return pick(new[0], kept[0]), pick(new[1], kept[1])

    a, b = fresh.memory, old.memory
    memory = Memory(law=pick(a.law, b.law), own=both(a.own, b.own), past=pick(a.past, b.past))
    return Seen(features=pick(fresh.features, old.features), base=pick(fresh.base, old.base), memory=memory)
