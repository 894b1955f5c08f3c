"""Small valid contents of files that more than one reader gets."""

from dataclasses import fields, is_dataclass
from pathlib import Path
from types import UnionType
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

import numpy as np

from ffgym.core.types import Array
from ffgym.recordings import Header, Phase, Recording, write_recording

ROWS = 24
"""Rows of a small recording."""
T: Array = 0.004 * np.arange(ROWS, dtype=np.float64)
"""Times of its rows [s]."""
Q: Array = np.stack([np.sin(30 * T), np.cos(20 * T)], axis=1)
"""Motor angles of its two joints, (T, 2) [rad]."""
JOINTS = ("upper", "lower")
RATIOS = (120.0, -80.0)


def small_recording(segment: str = "swing") -> Recording:
    """Two joints with torques, a tool, a column of the user's own and two phases."""
    header = Header(
        robot="press",
        joints=JOINTS,
        gear_ratio=RATIOS,
        torque_semantics="motor_side",
        hold="zoh",
        encoder_bits=17,
        filters=("low-pass 100 Hz",),
        payload={"mass": 2.0, "com": [0.0, 0.0, 0.1]},
        segment=segment,
        phases=(
            Phase(label="rest", kind="standstill", start=0.0, end=0.02),
            Phase(label="swing", kind="motion", start=0.02, end=0.08),
        ),
        provenance={"versions": {"ffgym": "1"}, "seed": 1},
        units={"user.gap": "m"},
        meta={"session_start": 0.0, "note": "dry"},
    )
    columns = {"timestamp": T, "user.gap": 1e-3 * T}
    for j, joint in enumerate(JOINTS):
        columns |= {f"motor.position.{joint}": Q[:, j], f"motor.effort.{joint}": 10 * Q[:, j]}
        columns |= {f"reference.position.{joint}": Q[:, j] + 1e-4}
    columns |= {f"tcp.position.{axis}": 0.1 * Q[:, 0] for axis in "xyz"}
    return Recording(columns, header)


def write_sample(path: Path, segment: str = "swing") -> Path:
    """Write the small recording."""
    write_recording(small_recording(segment), path)
    return path


def sample_of(kind: Any) -> Any:
    """Make JSON that `ffgym.core.typed_json.from_json` takes for a type, with one entry in every list."""
    origin, arguments = get_origin(kind), get_args(kind)
    if is_dataclass(kind):
        types = get_type_hints(kind)
        return {field.name: sample_of(types[field.name]) for field in fields(kind)}
    if origin is Literal:
        return arguments[0]
    if origin in (Union, UnionType):
        return sample_of(arguments[0])
    if origin is tuple:
        return [sample_of(argument) for argument in arguments if argument is not ...]
    if origin is dict:
        return {"name": sample_of(arguments[1])}
    values: dict[Any, Any] = {float: 0.5, int: 1, bool: True, str: "text"}
    return values.get(kind)
