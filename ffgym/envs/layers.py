"""Layers between agent and robot: residuals on a base, history, filters, a slower decision rate.

Layers are given as `layers=(innermost, ..., outermost)` to `gym.make` and `gym.make_vec` alike. They live inside the
environment, below the automatic reset: each is written once, for a batch, and works the same in the single and the
vector environment, in every autoreset mode and in the SB3 adapter. (Gymnasium's own wrappers work outside as usual, but
`make_vec` takes none for an environment that is a vector environment by nature.)
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, final

import numpy as np
from gymnasium import spaces

from ffgym.control import Agent, FeedForwardLaw, invert_servo
from ffgym.core.errors import FFGymError, check_number, check_shape, check_whole
from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.envs.core import TrackingCore
from ffgym.envs.motion import EpisodeMotion
from ffgym.envs.tasks import KEPT, EngineStage, Transition, copy_changing, restore_changing


class Layer(ABC):
    """Description of a layer; `over` builds it."""

    @abstractmethod
    def over(self, inner: EngineStage, core: TrackingCore) -> EngineStage:
        """Build the layer on top of `inner`, whose lowest stage is `core`."""


class PassThroughStage:
    """A stage that changes nothing, to derive from; it lists in `changing` the attributes that steps change."""

    changing: ClassVar[tuple[str, ...]] = ()
    """Attributes that steps and resets change, by which an episode can be gone on with later."""

    def __init__(self, inner: EngineStage, core: TrackingCore) -> None:
        self.inner, self.core = inner, core
        self.observation_space, self.action_space = inner.observation_space, inner.action_space
        self.decision_dt = inner.decision_dt

    def reset(self, ids: IntArray, options: Sequence[Mapping[str, Any]]) -> Array:
        """Begin episodes below."""
        return self.inner.reset(ids, options)

    def step(self, action: Array, active: BoolArray | None = None) -> Transition:
        """Step below."""
        return self.inner.step(action, active)

    def save(self) -> list[dict[str, Any]]:
        """Copy all that changes, here first."""
        return [copy_changing(self, self.changing), *self.inner.save()]

    def restore(self, saved: Sequence[Mapping[str, Any]]) -> None:
        """Go back."""
        restore_changing(self, saved[0])
        self.inner.restore(saved[1:])


def stack_layers(core: TrackingCore, layers: Sequence[Layer]) -> EngineStage:
    """Stack layers on the engine, the first one lowest.

    Raises:
        FFGymError: if one of them is no layer, or does not fit the one below.
    """
    stage: EngineStage = core
    for layer in layers:
        if not isinstance(layer, Layer):
            raise FFGymError(f"layers must hold layers of ffgym.envs such as History(8), got {layer!r}.")
        stage = layer.over(stage, core)
    return stage


@final
@dataclass(frozen=True)
class History(Layer):
    """The last `length` observations side by side, the newest first, so that the layout still reads it.

    At the start of an episode the first observation stands for those before it.
    """

    length: int

    def __post_init__(self) -> None:
        object.__setattr__(self, "length", check_whole("history length", self.length, low=1))

    def over(self, inner: EngineStage, core: TrackingCore) -> EngineStage:
        """Build the stage that keeps past observations."""
        return _HistoryStage(inner, core, self.length)


class _HistoryStage(PassThroughStage):
    changing = ("_past",)

    def __init__(self, inner: EngineStage, core: TrackingCore, length: int) -> None:
        super().__init__(inner, core)
        box = inner.observation_space
        low, high = np.tile(box.low, length), np.tile(box.high, length)
        self.observation_space = spaces.Box(low, high, dtype=np.float64)
        self._past = np.zeros((core.n, length, box.shape[0]))

    def reset(self, ids: IntArray, options: Sequence[Mapping[str, Any]]) -> Array:
        observation = self.inner.reset(ids, options)
        self._past[ids] = observation[ids, None]
        return self._flat()

    def step(self, action: Array, active: BoolArray | None = None) -> Transition:
        result = self.inner.step(action, active)
        rows = slice(None) if active is None else active
        self._past[rows, 1:] = self._past[rows, :-1].copy()
        self._past[rows, 0] = result.observation[rows]
        return replace(result, observation=self._flat())

    def _flat(self) -> Array:
        return self._past.reshape(len(self._past), -1).copy()


@final
@dataclass(frozen=True)
class LowPassAction(Layer):
    """First-order low-pass filter on the action; it starts at zero."""

    cutoff: float
    """Cut-off frequency [Hz]."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "cutoff", check_number("cutoff", self.cutoff, unit="Hz", low=0.0, open_low=True))

    def over(self, inner: EngineStage, core: TrackingCore) -> EngineStage:
        """Build the stage that filters actions."""
        return _LowPassStage(inner, core, 1 - np.exp(-2 * np.pi * self.cutoff * inner.decision_dt))


class _LowPassStage(PassThroughStage):
    changing = ("_filtered",)

    def __init__(self, inner: EngineStage, core: TrackingCore, share: float) -> None:
        super().__init__(inner, core)
        self._share = share
        self._filtered = np.zeros((core.n, inner.action_space.shape[0]))

    def reset(self, ids: IntArray, options: Sequence[Mapping[str, Any]]) -> Array:
        observation = self.inner.reset(ids, options)
        self._filtered[ids] = 0.0
        return observation

    def step(self, action: Array, active: BoolArray | None = None) -> Transition:
        moved = self._filtered + self._share * (np.clip(action, -1.0, 1.0) - self._filtered)
        self._filtered = moved if active is None else np.where(active[:, None], moved, self._filtered)
        return self.inner.step(self._filtered, active)


@final
@dataclass(frozen=True)
class Hold(Layer):
    """One decision every `steps` control steps: the action is held, rewards add up; an episode may end in between."""

    steps: int

    def __post_init__(self) -> None:
        object.__setattr__(self, "steps", check_whole("held steps", self.steps, unit="control steps", low=1))

    def over(self, inner: EngineStage, core: TrackingCore) -> EngineStage:
        """Build the stage that holds actions."""
        return _HoldStage(inner, core, self.steps)


class _HoldStage(PassThroughStage):
    def __init__(self, inner: EngineStage, core: TrackingCore, steps: int) -> None:
        super().__init__(inner, core)
        self._steps = steps
        self.decision_dt = steps * inner.decision_dt

    def step(self, action: Array, active: BoolArray | None = None) -> Transition:
        total = self.inner.step(action, active)
        going = np.ones(self.core.n, dtype=np.bool_) if active is None else active
        for _ in range(self._steps - 1):
            going = going & ~(total.terminated | total.truncated)
            if not going.any():
                break
            result = self.inner.step(action, going)
            total = Transition(
                observation=result.observation,
                reward=total.reward + result.reward,
                terminated=total.terminated | result.terminated,
                truncated=total.truncated | result.truncated,
            )
        return total


@final
@dataclass(frozen=True, eq=False)
class ResidualAction(Layer):
    """Sum of the agent's action and that of a base: a feed-forward law, or any agent with SB3's `predict`.

    A law computes its torque from the whole reference, as in `ffgym.simulation`; an agent sees the observations of the
    stage below. The sum is clipped to [-1, 1].
    """

    base: FeedForwardLaw | Agent
    scale: float = 1.0
    """Share of an action of 1 that the agent may add."""
    deterministic: bool = True
    """True if an agent as base acts without exploration noise."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "scale", check_number("residual scale", self.scale, low=0.0))
        if isinstance(self.base, type) or not isinstance(self.base, FeedForwardLaw | Agent):
            raise FFGymError(
                f"The base of a residual must be a feed-forward law or have a method predict, got {self.base!r}."
            )

    def over(self, inner: EngineStage, core: TrackingCore) -> EngineStage:
        """Build the stage that adds actions to those of the base."""
        if isinstance(self.base, FeedForwardLaw):
            return _ResidualLawStage(inner, core, self.base, self.scale)
        return _ResidualAgentStage(inner, core, self)


class _ResidualLawStage(PassThroughStage):
    changing = ("_torques", "_motions")

    def __init__(self, inner: EngineStage, core: TrackingCore, law: FeedForwardLaw, scale: float) -> None:
        super().__init__(inner, core)
        if inner.decision_dt != core.robot.servo.control_dt:
            raise FFGymError("A feed-forward law acts at every control step; put ResidualAction below Hold.")
        self._law, self._scale = law, scale
        self._torques: list[Array] = [np.zeros((0, 0))] * core.n
        self._motions: list[EpisodeMotion | None] = [None] * core.n
        self._known: dict[int, tuple[EpisodeMotion, Array]] = {}

    def reset(self, ids: IntArray, options: Sequence[Mapping[str, Any]]) -> Array:
        observation = self.inner.reset(ids, options)
        self._follow_motions()
        return observation

    def _follow_motions(self) -> None:
        """Look up the torques where a motion is another one than in the last step: an episode may have several."""
        for i, motion in enumerate(self.core.motions):
            if motion is not None and motion is not self._motions[i]:
                self._torques[i], self._motions[i] = self._along(motion), motion

    def _along(self, motion: EpisodeMotion) -> Array:
        """Compute the actions of the law along a motion, (T, N); kept, as many episodes share a motion."""
        if id(motion) not in self._known:
            if len(self._known) >= KEPT:
                self._known.clear()
            name = f"torque of feed-forward law {self._law.name!r}"
            torque = check_shape(name, self._law.torque(motion.reference), motion.reference.q.shape)
            if self.core.corrections is not None:
                torque = invert_servo(self.core.robot.servo, torque)
            self._known[id(motion)] = (motion, torque / self.core.action_size)
        return self._known[id(motion)][1]

    def step(self, action: Array, active: BoolArray | None = None) -> Transition:
        self._follow_motions()
        ends = np.minimum(self.core.step_index + 1, [len(torque) - 1 for torque in self._torques])
        base = np.stack([torque[k] for torque, k in zip(self._torques, ends, strict=True)])
        return self.inner.step(base + self._scale * np.clip(action, -1.0, 1.0), active)


class _ResidualAgentStage(PassThroughStage):
    changing = ("_memory", "_starts", "_observation")

    def __init__(self, inner: EngineStage, core: TrackingCore, layer: ResidualAction) -> None:
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
        assert isinstance(layer.base, Agent)  # ResidualAction.over chose this stage for it
        base, self._memory = layer.base.predict(
            self._observation.copy(), self._memory, self._starts.copy(), deterministic=layer.deterministic
        )
        base = check_shape("actions of the base agent", base, action.shape)
        self._starts = np.zeros_like(self._starts) if active is None else self._starts & ~active
        result = self.inner.step(base + layer.scale * np.clip(action, -1.0, 1.0), active)
        self._observation = result.observation
        return result
