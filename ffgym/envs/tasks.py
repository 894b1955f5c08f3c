"""What an environment's episodes are: a family of motions, from which each episode draws one."""

from abc import ABC, abstractmethod
from collections import OrderedDict
from collections.abc import Callable, Hashable, Mapping
from typing import Any, ClassVar

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.envs.motion import Motion
from ffgym.robot import RigidArm, RobotDescription

KEPT = 128
"""Motions kept per environment: more than all of the thesis' circle test, in any order of its circles."""


class Tasks(ABC):
    """A family of motions of one robot."""

    option_names: ClassVar[tuple[str, ...]]
    """What `reset(options=...)` may fix for an episode."""

    def __init__(self, robot: RobotDescription) -> None:
        self.robot = robot
        self.arm = RigidArm(robot)
        self._cache: OrderedDict[Hashable, Motion] = OrderedDict()

    @abstractmethod
    def draw(self, rng: np.random.Generator, options: Mapping[str, Any]) -> Motion:
        """Return a motion; what `options` leave open is drawn.

        Raises:
            FFGymError: if an option is not valid, or the robot cannot follow the motion.
        """

    def listed(self) -> list[dict[str, Any]]:
        """Options of every motion of the family, in order; empty if they cannot be listed."""
        return []

    def _cached(self, key: Hashable, make: Callable[[], Motion]) -> Motion:
        """Motion of that key, made once; the least recently used ones are forgotten."""
        if key not in self._cache:
            self._cache[key] = make()
            if len(self._cache) > KEPT:
                self._cache.popitem(last=False)
        self._cache.move_to_end(key)
        return self._cache[key]


def check_not_empty(name: str, values: tuple[Any, ...], example: str) -> tuple[Any, ...]:
    """Return `values` if there are any.

    Raises:
        FFGymError: if not.
    """
    if not values:
        raise FFGymError(f"{name} is empty, must hold at least one, e.g. {example}.")
    return values
