"""What engine and layers have in common: they begin episodes and make steps, for a batch."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from gymnasium import spaces

from ffgym.core.types import Array, BoolArray, IntArray


@dataclass(frozen=True, kw_only=True, eq=False)
class Transition:
    """What a step brings in B sub-environments."""

    observation: Array
    """Shape (B, D)."""
    reward: Array
    """Shape (B,); 0 where nothing was stepped."""
    terminated: BoolArray
    """Emergency stop, shape (B,)."""
    truncated: BoolArray
    """End of the motion or of the horizon, shape (B,)."""


class Stage(Protocol):
    """The engine, or a layer on top of it."""

    observation_space: spaces.Box
    action_space: spaces.Box
    decision_dt: float
    """Time between actions [s]."""

    def reset(self, ids: IntArray, options: Sequence[Mapping[str, Any]]) -> Array:
        """Begin episodes in sub-environments `ids`, with options for each; returns all observations, (B, D)."""

    def step(self, action: Array, active: BoolArray | None = None) -> Transition:
        """One decision where `active`, shape (B,), None is everywhere; `action` (B, N) is finite."""


class Observer(Protocol):
    """Something that watches an engine, and leaves it as it is."""

    def begin(self, ids: IntArray) -> None:
        """Sub-environments `ids` have begun an episode."""

    def follow(self, ids: IntArray) -> None:
        """Sub-environments `ids` have done a control step."""
