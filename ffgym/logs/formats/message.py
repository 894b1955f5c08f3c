"""A ROS message as flat numbers."""

from collections.abc import Iterator, Sequence
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

NANOSECONDS = 10**9
"""Per second: a stamp is whole seconds and nanoseconds."""

_TIMES = frozenset({"builtin_interfaces/msg/Time", "builtin_interfaces/msg/Duration"})

_NAMING = ("name", "joint_names")
"""Fields in which messages list their joints: sensor_msgs/JointState, and those of ros2_control."""


def joint_names(message: Any) -> tuple[str, ...] | None:
    """Joints that a message names, in its order; None if it names none."""
    for field in _NAMING:
        names = getattr(message, field, None)
        if isinstance(names, list) and names and all(isinstance(name, str) for name in names):
            return tuple(names)
    return None


def flat(message: Any, joints: Sequence[str] | None) -> dict[str, Any]:
    """Numbers of a message by path; arrays with one entry per joint of `joints` are split by joint.

    Text is left out, and so are arrays of bytes, which are pictures and the like.
    """
    numbers: dict[str, Any] = {}
    for path, value in _leaves("", message):
        if joints is not None and isinstance(value, np.ndarray) and value.shape == (len(joints),):
            numbers |= {f"{path}.{joint}": entry for joint, entry in zip(joints, value, strict=True)}
        else:
            numbers[path] = value
    return numbers


def _leaves(path: str, value: Any) -> Iterator[tuple[str, Any]]:
    if getattr(value, "__msgtype__", "") in _TIMES:
        yield path, np.int64(value.sec * NANOSECONDS + value.nanosec)
    elif is_dataclass(value):
        for field in fields(value):
            yield from _leaves(f"{path}.{field.name}" if path else field.name, getattr(value, field.name))
    elif isinstance(value, np.ndarray):
        if value.dtype.kind in "biuf" and value.dtype != np.uint8 and value.size:
            yield path, value
    elif isinstance(value, list):
        for i, entry in enumerate(value):
            yield from _leaves(f"{path}[{i}]", entry)
    elif isinstance(value, bool | int | float):
        yield path, value
