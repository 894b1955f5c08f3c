"""How one part of a MuJoCo specification becomes an element of MJCF, with numbers that read back exactly."""

from typing import Any
from xml.etree import ElementTree as ET

import mujoco
import numpy as np

from ffgym.core.errors import FFGymError

_ATTRIBUTES = {
    "joint": "name type pos axis ref range limited margin stiffness springref damping armature frictionloss group",
    "geom": "name type mesh material size pos quat fromto contype conaffinity group rgba mass",
    "site": "name type size pos quat group rgba",
    "light": "name type pos dir castshadow ambient diffuse specular",
    "texture": "name type builtin rgb1 rgb2 width height",
    "material": "name rgba specular shininess reflectance",
    "mesh": "name inertia scale vertex face",
    "tendon": "name range limited stiffness damping springlength armature frictionloss width rgba group",
    "actuator": "name gear damping armature forcelimited forcerange ctrllimited ctrlrange group",
}
"""Attributes of each element, in the order in which they are written."""

_FIELDS = {"mesh": "meshname", "vertex": "uservert", "face": "userface"}
"""Fields of the specification that have another name than their attribute."""

_VECTORS = {"vertex": np.float32, "face": np.int32}
"""Attributes of any length, which the specification keeps in lists of its own, and what is in them."""

_SHORTENED = {"size", "gear", "stiffness", "damping"}
"""Attributes that need not have all their numbers: zeros at the end are left out."""

_INPUTS = {
    "pos": mujoco.mjtCtrlInput.mjINPUT_POS,
    "vel": mujoco.mjtCtrlInput.mjINPUT_VEL,
    "ff": mujoco.mjtCtrlInput.mjINPUT_FF,
}
"""Inputs of a servo, in the order in which they stand in `data.ctrl`."""

_DEFAULTS = mujoco.MjSpec().default
"""MuJoCo's own defaults, which need not be written."""


def element(kind: str, part: Any, tag: str = "") -> ET.Element:
    """Element with those attributes of `part` that are not MuJoCo's defaults; `tag` names it where `kind` does not."""
    out, default = ET.Element(tag or kind), getattr(_DEFAULTS, kind)
    for name in _ATTRIBUTES[kind].split():
        field = _FIELDS.get(name, name)
        value, usual = getattr(part, field), getattr(default, field, "")
        if name in _VECTORS:
            value, usual = np.array(list(value), dtype=_VECTORS[name]), np.zeros(0)
        if not _same(value, usual):
            out.set(name, text(value, shortened=name in _SHORTENED))
    return out


def inertial_element(body: Any) -> ET.Element:
    """Mass, centre of mass and inertia of a body, as the builder was given them."""
    out = ET.Element("inertial", pos=text(body.ipos), mass=text(body.mass))
    if np.isnan(body.fullinertia[0]):  # not given: the body never turns
        out.set("diaginertia", text(body.inertia))
    else:  # also where it is diagonal, for which MuJoCo finds other principal axes when it is said so
        out.set("fullinertia", text(body.fullinertia))
    return out


def actuator_element(part: Any) -> ET.Element:
    """A servo as `pid` or a friction as `dcmotor`, whose attributes say what the numbers are.

    Raises:
        FFGymError: if it is another kind of actuator.
    """
    gain, bias, dynamics = part.gainprm, part.biasprm, part.dynprm
    if part.gaintype == mujoco.mjtGain.mjGAIN_PID:
        out = element("actuator", part, "pid")
        numbers = {"kp": -bias[1], "kv": -bias[2], "ki": gain[0], "imax": dynamics[0]}
        inputs = " ".join(name for name, bit in _INPUTS.items() if part.ctrlspec & int(bit))
    elif part.gaintype == mujoco.mjtGain.mjGAIN_DCMOTOR:
        out = element("actuator", part, "dcmotor")
        numbers = {"motorconst": np.zeros(2), "resistance": gain[0], "lugre": np.array([*dynamics[5:7], *bias[3:6]])}
        inputs = "none"
    else:
        raise FFGymError(f"Actuator {part.name!r} is neither a servo (pid) nor a friction (dcmotor). Leave it out.")
    out.set("joint" if part.trntype == mujoco.mjtTrn.mjTRN_JOINT else "tendon", part.target)
    for name, value in numbers.items():
        out.set(name, text(value))
    out.set("input", inputs)
    return out


def tendon_element(part: Any) -> ET.Element:
    """A weighted sum of joint positions, or a line through sites."""
    path = list(part.path)
    fixed = path[0].type == mujoco.mjtWrap.mjWRAP_JOINT
    out = element("tendon", part, "fixed" if fixed else "spatial")
    for wrap in path:
        if fixed:
            ET.SubElement(out, "joint", joint=wrap.target.name, coef=text(wrap.coef))
        else:
            ET.SubElement(out, "site", site=wrap.target.name)
    return out


def key_element(key: Any) -> ET.Element:
    """A state to start from."""
    out = ET.Element("key", name=key.name)
    for name in ("qpos", "qvel", "act", "ctrl"):
        values = np.array(list(getattr(key, name)))
        if values.size:
            out.set(name, text(values))
    return out


def text(value: Any, *, shortened: bool = False) -> str:
    """Text of a name, a keyword, a number or a vector; numbers have the fewest digits that give back every bit."""
    if isinstance(value, str):
        return value
    if hasattr(value, "__members__"):  # MuJoCo's enumerations are no Enum: mjGEOM_BOX is `box`
        return str(value.name).rsplit("_", 1)[-1].lower()
    if isinstance(value, np.ndarray):
        length = max([1, *(np.flatnonzero(value) + 1)]) if shortened else len(value)
        return " ".join(text(x) for x in value[:length])
    return str(value).lower().removesuffix(".0")


def _same(a: Any, b: Any) -> bool:
    """Whether two values are equal, where NaN, MuJoCo's word for what is not given, equals NaN."""
    if isinstance(a, np.ndarray):
        return np.array_equal(a, b, equal_nan=True)
    return bool(a == b or (a != a and b != b))
