"""What a layer is: a description that is put over a stage."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.envs.core import TrackingCore
from ffgym.envs.stage import Stage, Transition


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
