"""Laws with weights: what learning asks of them, whatever they are made of."""

from abc import abstractmethod
from collections.abc import Sequence
from typing import Self

import numpy as np

from ffgym.agents.common.law_files import StoredLaw
from ffgym.agents.common.trials import Lesson
from ffgym.control import CausalLaw
from ffgym.core.types import Array, BoolArray


class Network(CausalLaw, StoredLaw):
    """A law that learns from trials. A network is never changed: learning returns a new one."""

    @property
    @abstractmethod
    def weights(self) -> dict[str, Array]:
        """Learned numbers by name; the first axis of each counts joints, shape (N, ...)."""

    @abstractmethod
    def with_weights(self, weights: dict[str, Array]) -> Self:
        """The same network with other weights."""

    @abstractmethod
    def adapted(self, lessons: Sequence[Lesson], rate: float) -> Self:
        """What the network is after one update from the lessons of one trial, at learning rate `rate`."""

    def merged(self, other: Self, joints: BoolArray) -> Self:
        """This network, with the weights of `other` on `joints` (N,)."""
        theirs = other.weights
        return self.with_weights(
            {name: np.where(_over(joints, own), theirs[name], own) for name, own in self.weights.items()}
        )


def _over(joints: BoolArray, weights: Array) -> BoolArray:
    return joints.reshape(-1, *[1] * (weights.ndim - 1))
