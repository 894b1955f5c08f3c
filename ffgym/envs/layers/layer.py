"""Layers below the automatic reset: history, hold, low-pass; written once for a batch, they serve every interface."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, final

import numpy as np
from gymnasium import spaces

from ffgym.core.errors import FFGymError, check_number, check_whole
from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.envs.core import TrackingCore
from ffgym.envs.tasks import Stage, Transition


class Layer(ABC):
    """Description of a layer; `over` builds it."""

    @abstractmethod
    def over(self, inner: Stage, core: TrackingCore) -> Stage:
        """The layer on top of `inner`, whose lowest stage is `core`."""


class Passing:
    """A stage that changes nothing, to derive from."""

    def __init__(self, inner: Stage, core: TrackingCore) -> None:
        self.inner, self.core = inner, core
        self.observation_space, self.action_space = inner.observation_space, inner.action_space
        self.decision_dt = inner.decision_dt

    def reset(self, ids: IntArray, options: Sequence[Mapping[str, Any]]) -> Array:
        """See `Stage`."""
        return self.inner.reset(ids, options)

    def step(self, action: Array, active: BoolArray | None = None) -> Transition:
        """See `Stage`."""
        return self.inner.step(action, active)


def stacked(core: TrackingCore, layers: Sequence[Layer]) -> Stage:
    """The engine with layers on top, the first one lowest.

    Raises:
        FFGymError: if one of them is no layer, or does not fit the one below.
    """
    stage: Stage = core
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

    def over(self, inner: Stage, core: TrackingCore) -> Stage:
        """See base class."""
        return _HistoryStage(inner, core, self.length)


class _HistoryStage(Passing):
    def __init__(self, inner: Stage, core: TrackingCore, length: int) -> None:
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
class LowPass(Layer):
    """First-order low-pass filter on the action; it starts at zero."""

    cutoff: float
    """[Hz]."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "cutoff", check_number("cutoff", self.cutoff, unit="Hz", low=0.0, open_low=True))

    def over(self, inner: Stage, core: TrackingCore) -> Stage:
        """See base class."""
        return _LowPassStage(inner, core, 1 - np.exp(-2 * np.pi * self.cutoff * inner.decision_dt))


class _LowPassStage(Passing):
    def __init__(self, inner: Stage, core: TrackingCore, share: float) -> None:
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

    def over(self, inner: Stage, core: TrackingCore) -> Stage:
        """See base class."""
        return _HoldStage(inner, core, self.steps)


class _HoldStage(Passing):
    def __init__(self, inner: Stage, core: TrackingCore, steps: int) -> None:
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
