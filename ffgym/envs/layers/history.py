"""Observations of the past beside the present one."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, final

import numpy as np
from gymnasium import spaces

from ffgym.core.errors import check_whole
from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.envs.core import TrackingCore
from ffgym.envs.layers.layer import Layer, Passing
from ffgym.envs.stage import Stage, Transition


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
