"""What is done to actions in time: a low-pass filter, and a slower decision rate."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, final

import numpy as np

from ffgym.core.errors import check_number, check_whole
from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.envs.core import TrackingCore
from ffgym.envs.layers.layer import Layer, Passing
from ffgym.envs.stage import Stage, Transition


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
