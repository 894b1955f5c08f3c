"""What each field of a header must be; each function returns it as the header keeps it."""

import json
import re
from itertools import pairwise
from typing import Any

import numpy as np

from ffgym.core.errors import FFGymError, check_choice, check_number, check_shape
from ffgym.recordings.phase import Phase
from ffgym.recordings.schema import USER_PREFIX

JOINT_NAME = re.compile(r"[A-Za-z0-9_/-]+")
"""What a joint may be called, so that its name can end the names of columns."""


def as_text(name: str, value: Any, *, empty: bool = False) -> str:
    """Text, not empty unless `empty` allows it."""
    if not isinstance(value, str) or not (value or empty):
        raise FFGymError(f"header {name} must be {'text' if empty else 'non-empty text'}, got {value!r}.")
    return value


def as_texts(name: str, value: Any) -> tuple[str, ...]:
    """Tuple of text."""
    if not isinstance(value, tuple | list) or not all(isinstance(item, str) for item in value):
        raise FFGymError(f"header {name} must be a tuple of text, got {value!r}.")
    return tuple(str(item) for item in value)


def as_joints(value: Any) -> tuple[str, ...]:
    """Joint names: distinct, safe in column names and files."""
    joints = as_texts("joints", value)
    if not joints or len(set(joints)) < len(joints):
        raise FFGymError(f"header joints = {joints} must be at least one name, each once.")
    for joint in joints:
        if not JOINT_NAME.fullmatch(joint):
            raise FFGymError(f"header joints: {joint!r} must be letters, digits or any of _ / -")
    return joints


def as_ratios(value: Any, n_joints: int) -> tuple[float, ...]:
    """Gear ratios, one per joint, not zero."""
    ratios = check_shape("header gear_ratio", value, (n_joints,))
    if np.any(ratios == 0):
        raise FFGymError(f"header gear_ratio = {tuple(ratios.tolist())} must not be zero; write 1 for a direct drive.")
    return tuple(ratios.tolist())


def as_coupling(value: Any, n_joints: int) -> tuple[tuple[float, ...], ...] | None:
    """Matrix of couplings between axes, zero on its diagonal; None if there are none."""
    if value is None:
        return None
    coupling = check_shape("header coupling", value, (n_joints, n_joints))
    if np.any(np.diag(coupling)):
        raise FFGymError(f"header coupling has {np.diag(coupling)} on its diagonal, must be 0; see gear_ratio.")
    return tuple(tuple(row) for row in coupling.tolist())


def as_joint_types(value: Any, n_joints: int) -> tuple[str, ...]:
    """'hinge' or 'slide' for each joint; nothing is all hinges."""
    types = as_texts("joint_types", value) or ("hinge",) * n_joints
    for kind in types:
        check_choice("header joint_types entry", kind, ("hinge", "slide"))
    if len(types) != n_joints:
        raise FFGymError(f"header joint_types = {types} must be one for each of {n_joints} joints.")
    return types


def as_bits(value: Any) -> int | None:
    """Encoder resolution [bit], or None."""
    if value is not None and (isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= 64):
        raise FFGymError(f"header encoder_bits = {value!r} must be an integer in [1, 64], or None.")
    return value


def as_phases(value: Any) -> tuple[Phase, ...]:
    """Phases in order, without overlap."""
    if not isinstance(value, tuple | list) or not all(isinstance(phase, Phase) for phase in value):
        raise FFGymError(f"header phases must be a tuple of Phase, got {value!r}.")
    for before, after in pairwise(value):
        if after.start < before.end:
            raise FFGymError(
                f"Phase {after.label!r} starts at {after.start} s, before {before.label!r} ends at {before.end} s. "
                "Phases must be in order and must not overlap."
            )
    return tuple(value)


def as_payload(value: Any) -> dict[str, Any]:
    """Payload with its mass [kg] and, where known, `com` [m] and `inertia` [kg m^2]."""
    known = ("mass", "com", "inertia")
    payload = as_json("payload", value)
    for name in payload:
        check_choice("header payload entry", name, known)
    if "mass" not in payload:
        raise FFGymError("header payload has no mass [kg]. Give 0 for none, or payload=None if unknown.")
    payload["mass"] = check_number("header payload mass", payload["mass"], unit="kg", low=0.0)
    for name, shape in (("com", (3,)), ("inertia", (3, 3))):
        if name in payload:
            payload[name] = check_shape(f"header payload {name}", payload[name], shape).tolist()
    return payload


def as_units(value: Any) -> dict[str, str]:
    """Units of user columns."""
    units = as_json("units", value)
    for name, unit in units.items():
        if not name.startswith(USER_PREFIX) or not isinstance(unit, str) or not unit:
            raise FFGymError(f"header units: {name!r} = {unit!r} must be a user.<name> column with its unit as text.")
    return units


def as_json(name: str, value: Any) -> dict[str, Any]:
    """Return `value` as it will be after a round trip through JSON; NumPy numbers and arrays become lists."""
    if not isinstance(value, dict):
        raise FFGymError(f"header {name} must be a dict, got {value!r}.")
    try:
        text = json.dumps(value, allow_nan=False, default=_plain)
    except (TypeError, ValueError, RecursionError) as error:
        raise FFGymError(f"header {name} must be JSON (no NaN, no objects): {error}.") from error
    copy: dict[str, Any] = json.loads(text)
    return copy


def _plain(value: Any) -> Any:
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    raise TypeError(f"{value!r} is not JSON")
