"""An agent on top of a feed-forward law, or of another agent."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, final

import numpy as np

from ffgym.control import Agent, FeedForwardLaw
from ffgym.core.errors import FFGymError, check_number, check_shape
from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.envs.core import TrackingCore
from ffgym.envs.layers.layer import Layer, Passing
from ffgym.envs.motion import Motion
from ffgym.envs.tasks import KEPT, Stage, Transition


@final
@dataclass(frozen=True, eq=False)
class Residual(Layer):
    """The agent's action is added to that of a base: a feed-forward law, or any agent with SB3's `predict`.

    A law computes its torque from the whole reference, as in `ffgym.simulation`; an agent sees the observations of the
    stage below. The sum is clipped to [-1, 1].
    """

    base: FeedForwardLaw | Agent
    scale: float = 1.0
    """Share of an action of 1 that the agent may add."""
    deterministic: bool = True
    """Whether an agent as base acts without exploration noise."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "scale", check_number("residual scale", self.scale, low=0.0))
        if isinstance(self.base, type) or not isinstance(self.base, FeedForwardLaw | Agent):
            raise FFGymError(
                f"The base of a residual must be a feed-forward law or have a method predict, got {self.base!r}."
            )

    def over(self, inner: Stage, core: TrackingCore) -> Stage:
        """See base class."""
        if isinstance(self.base, FeedForwardLaw):
            return _ResidualLawStage(inner, core, self.base, self.scale)
        return _ResidualAgentStage(inner, core, self)


class _ResidualLawStage(Passing):
    def __init__(self, inner: Stage, core: TrackingCore, law: FeedForwardLaw, scale: float) -> None:
        super().__init__(inner, core)
        if inner.decision_dt != core.robot.servo.control_dt:
            raise FFGymError("A feed-forward law acts at every control step; put Residual below Hold.")
        self._law, self._scale = law, scale
        self._torques: list[Array] = [np.zeros((0, 0))] * core.n
        self._known: dict[int, tuple[Motion, Array]] = {}

    def reset(self, ids: IntArray, options: Sequence[Mapping[str, Any]]) -> Array:
        observation = self.inner.reset(ids, options)
        for i in ids:
            motion = self.core.motions[i]
            assert motion is not None  # it was just reset
            self._torques[i] = self._along(motion)
        return observation

    def _along(self, motion: Motion) -> Array:
        """Actions of the law along a motion, (T, N); kept, as many episodes share a motion."""
        if id(motion) not in self._known:
            if len(self._known) >= KEPT:
                self._known.clear()
            name = f"torque of feed-forward law {self._law.name!r}"
            torque = check_shape(name, self._law.torque(motion.reference), motion.reference.q.shape)
            self._known[id(motion)] = (motion, torque / self.core.action_torque)
        return self._known[id(motion)][1]

    def step(self, action: Array, active: BoolArray | None = None) -> Transition:
        ends = np.minimum(self.core.step_index + 1, [len(torque) - 1 for torque in self._torques])
        base = np.stack([torque[k] for torque, k in zip(self._torques, ends, strict=True)])
        return self.inner.step(base + self._scale * np.clip(action, -1.0, 1.0), active)


class _ResidualAgentStage(Passing):
    def __init__(self, inner: Stage, core: TrackingCore, layer: Residual) -> None:
        super().__init__(inner, core)
        self._layer = layer
        self._memory: Any = None
        self._starts = np.ones(core.n, dtype=np.bool_)
        self._observation = np.zeros((core.n, inner.observation_space.shape[0]))

    def reset(self, ids: IntArray, options: Sequence[Mapping[str, Any]]) -> Array:
        self._observation = self.inner.reset(ids, options)
        self._starts[ids] = True
        return self._observation

    def step(self, action: Array, active: BoolArray | None = None) -> Transition:
        layer = self._layer
        assert isinstance(layer.base, Agent)  # Residual.over chose this stage for it
        base, self._memory = layer.base.predict(
            self._observation.copy(), self._memory, self._starts.copy(), deterministic=layer.deterministic
        )
        base = check_shape("actions of the base agent", base, self._action_shape)
        self._starts = np.zeros_like(self._starts) if active is None else self._starts & ~active
        result = self.inner.step(base + layer.scale * np.clip(action, -1.0, 1.0), active)
        self._observation = result.observation
        return result

    @property
    def _action_shape(self) -> tuple[int, int]:
        return (self.core.n, self.action_space.shape[0])
