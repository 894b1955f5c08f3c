"""Whether parts of two descriptions have the same numbers, so that nothing needs to be computed again."""

from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from ffgym.robot import RobotDescription

_OF_LINKS = ("bodies", "tool", "springs", "gravity", "kinematics")
"""Parts of a description that decide what links ask for."""


def same_links(one: RobotDescription, other: RobotDescription) -> bool:
    """Whether links ask for the same in the same motion."""
    return all(alike(getattr(one, part), getattr(other, part)) for part in _OF_LINKS)


def alike(one: Any, other: Any) -> bool:
    """Whether two parts of a description have the same numbers."""
    if one is other:
        return True
    if is_dataclass(one) and is_dataclass(other) and type(one) is type(other):
        return all(alike(getattr(one, f.name), getattr(other, f.name)) for f in fields(one))
    if isinstance(one, tuple | list) and isinstance(other, tuple | list):
        return len(one) == len(other) and all(alike(a, b) for a, b in zip(one, other, strict=True))
    return bool(np.array_equal(one, other))
