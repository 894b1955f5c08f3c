"""The model of a robot as MJCF that compiles to the same model, bit for bit.

MuJoCo's own writer keeps 6 digits. This one writes what `build_spec` builds, with all digits, and compares the compiled
models before it returns, so that nothing is lost unseen.
"""

import hashlib
from textwrap import fill
from typing import Any
from xml.etree import ElementTree as ET

import mujoco
import numpy as np

from ffgym.core.errors import FFGymError


def model_bytes(model: mujoco.MjModel) -> bytes:
    """The compiled model as in a .mjb file, which this version of MuJoCo loads."""
    buffer = np.empty(mujoco.mj_sizeModel(model), dtype=np.uint8)
    mujoco.mj_saveModel(model, None, buffer)
    return buffer.tobytes()


def physics_fingerprint(model: mujoco.MjModel) -> str:
    """Hash of the compiled model and the MuJoCo version, 16 hexadecimal digits."""
    digest = hashlib.sha256(mujoco.__version__.encode())
    digest.update(model_bytes(model))
    return digest.hexdigest()[:16]


def model_field(model: mujoco.MjModel, name: str) -> Any:
    """Field of a model by its name in `mujoco.batch.MODEL_FIELDS`, where options are called 'opt.<name>'."""
    return getattr(model.opt, name[4:]) if name.startswith("opt.") else getattr(model, name)


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
    """Write an element with attributes of `part` that are not MuJoCo's defaults; `tag` may name it, else `kind`."""
    out, default = ET.Element(tag or kind), getattr(_DEFAULTS, kind)
    for name in _ATTRIBUTES[kind].split():
        field = _FIELDS.get(name, name)
        value, usual = getattr(part, field), getattr(default, field, "")
        if name in _VECTORS:
            value, usual = np.array(list(value), dtype=_VECTORS[name]), np.zeros(0)
        if not _same(value, usual):
            out.set(name, text(value, shortened=name in _SHORTENED))
    return out


def actuator_element(part: Any) -> ET.Element:
    """A servo as `pid`, with a torque loop as `dcmotor`, or a friction as `dcmotor`; attributes name the numbers."""
    gain, bias, dynamics = part.gainprm, part.biasprm, part.dynprm
    inputs = " ".join(name for name, bit in _INPUTS.items() if part.ctrlspec & int(bit)) or "none"
    if part.gaintype == mujoco.mjtGain.mjGAIN_PID:
        out = element("actuator", part, "pid")
        numbers = {"kp": -bias[1], "kv": -bias[2], "ki": gain[0], "imax": dynamics[0]}
    elif part.gaintype == mujoco.mjtGain.mjGAIN_DCMOTOR and inputs != "none":
        out = element("actuator", part, "dcmotor")
        for name in ("forcelimited", "forcerange"):  # which saturation sets
            out.attrib.pop(name, None)
        numbers = {
            "motorconst": gain[[1, 1]],
            "resistance": gain[0],
            "inductance": np.array([0.0, dynamics[0]]),
            "saturation": np.array([part.forcerange[1], 0.0, dynamics[1]]),
            "controller": np.array([gain[4], gain[5], gain[6], 0.0, dynamics[8], gain[7]]),
        }
    elif part.gaintype == mujoco.mjtGain.mjGAIN_DCMOTOR:
        out = element("actuator", part, "dcmotor")
        numbers = {"motorconst": np.zeros(2), "resistance": gain[0], "lugre": np.array([*dynamics[5:7], *bias[3:6]])}
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


def text(value: Any, *, shortened: bool = False) -> str:
    """Format a name, a keyword, a number or a vector; numbers have the fewest digits that give back every bit."""
    if isinstance(value, str):
        return value
    if hasattr(value, "__members__"):  # MuJoCo's enumerations are no Enum: mjGEOM_BOX is `box`
        return str(value.name).rsplit("_", 1)[-1].lower()
    if isinstance(value, np.ndarray):
        length = max([1, *(np.flatnonzero(value) + 1)]) if shortened else len(value)
        return " ".join(text(x) for x in value[:length])
    return str(value).lower().removesuffix(".0")


def _same(a: Any, b: Any) -> bool:
    """Compare two values, where NaN, MuJoCo's word for absent numbers, equals NaN."""
    if isinstance(a, np.ndarray):
        return np.array_equal(a, b, equal_nan=True)
    return bool(a == b or (a != a and b != b))


_COMMENTS = {
    "worldbody": "The arm, link side, in SI units. JOINT_motor moves by motor angle / gear ratio and carries rotor "
    "inertia, friction and servo; JOINT_deflection behind it is the elasticity, and carries the link. The position of "
    "the joint is their sum.",
    "tendon": "Angles of motors that several joints turn, and of links with friction, in motor units (fixed), springs "
    "between links (spatial).",
    "actuator": "The drives, motor side: gear is motor turns per joint turn, so that set-points, gains and torques are "
    "those of the motor. data.ctrl has position [rad], velocity [rad/s] and feed-forward torque [N m] of each servo. "
    "lugre is stiffness, damping, Coulomb and static torque, Stribeck velocity of the friction; damping is viscous. "
    "Where the torque lags its command, a servo is a dcmotor whose current is the torque: inductance is the lag, the "
    "last number of saturation the fastest change per second, of a step. "
    "JOINT_arm_friction is the part of the friction that acts on the arm, behind the elasticity.",
    "keyframe": "States of equilibrium to start from: springs and servo integrals carry the load.",
}
"""Comments for a reader before each section."""

_INTEGRATORS = ("Euler", "RK4", "implicit", "implicitfast")
"""MJCF's words, in MuJoCo's order."""


def mjcf_text(spec: mujoco.MjSpec) -> str:
    """MJCF of a specification as `build_spec` makes it, before it is compiled; its `comment` stands on top.

    Raises:
        FFGymError: if the text would not compile to the same model, as the specification holds what robots do not.
    """
    root = ET.Element("mujoco", model=spec.modelname)
    ET.SubElement(root, "compiler", angle="degree" if spec.compiler.degree else "radian")
    # step, integrator, gravity, and what is switched off
    option = spec.option
    settings = {"timestep": text(option.timestep), "integrator": _INTEGRATORS[option.integrator]}
    out = ET.SubElement(root, "option", settings, gravity=text(option.gravity))
    for name, bit in mujoco.mjtDisableBit.__members__.items():
        if name.startswith("mjDSBL_") and option.disableflags & int(bit):
            flag = out[0] if len(out) else ET.SubElement(out, "flag")
            flag.set(name.removeprefix("mjDSBL_").lower(), "disable")
    for section in _sections(spec):
        if len(section):
            if section.tag in _COMMENTS:
                root.append(ET.Comment(f" {fill(_COMMENTS[section.tag], width=110, subsequent_indent=' ' * 7)} "))
            root.append(section)
    ET.indent(root)
    head = f"<!-- {spec.comment.replace('--', '- -')} -->\n" if spec.comment else ""
    result = head + ET.tostring(root, encoding="unicode") + "\n"
    _check_same(spec, result)
    return result


def _sections(spec: mujoco.MjSpec) -> list[ET.Element]:
    """All sections, in MJCF's usual order."""
    visual, assets, world, tendons, actuators, keys = (
        ET.Element(tag) for tag in ("visual", "asset", "worldbody", "tendon", "actuator", "keyframe")
    )
    for group in ("headlight", "map"):  # light at the camera and clipping planes, where they are not MuJoCo's
        own, usual = getattr(spec.visual, group), getattr(mujoco.MjSpec().visual, group)
        names = [name for name in dir(own) if not name.startswith("_")]
        changed = [name for name in names if not np.array_equal(getattr(own, name), getattr(usual, name))]
        if changed:
            ET.SubElement(visual, group, {name: text(getattr(own, name)) for name in changed})
    for kind, parts in (("texture", spec.textures), ("material", spec.materials), ("mesh", spec.meshes)):
        assets.extend([element(kind, part) for part in parts])
    _fill(world, spec.worldbody)
    tendons.extend([tendon_element(part) for part in spec.tendons])
    actuators.extend([actuator_element(part) for part in spec.actuators])
    for key in spec.keys:
        state = {name: np.array(list(getattr(key, name))) for name in ("qpos", "qvel", "act", "ctrl")}
        filled = {name: text(values) for name, values in state.items() if values.size}
        ET.SubElement(keys, "key", {"name": key.name, **filled})
    return [visual, assets, world, tendons, actuators, keys]


def _fill(out: ET.Element, body: Any) -> None:
    """Add what belongs to a body, and the bodies behind it."""
    for kind, parts in (("joint", body.joints), ("geom", body.geoms), ("site", body.sites), ("light", body.lights)):
        out.extend([element(kind, part) for part in parts])
    for child in body.bodies:
        inner = ET.SubElement(out, "body", name=child.name)
        for name, unmoved in (("pos", [0, 0, 0]), ("quat", [1, 0, 0, 0])):
            if not np.array_equal(getattr(child, name), unmoved):
                inner.set(name, text(getattr(child, name)))
        inertial = ET.SubElement(inner, "inertial", pos=text(child.ipos), mass=text(child.mass))
        if np.isnan(child.fullinertia[0]):  # not given: the body never turns
            inertial.set("diaginertia", text(child.inertia))
        else:  # also where it is diagonal, for which MuJoCo finds other principal axes when it is said so
            inertial.set("fullinertia", text(child.fullinertia))
        _fill(inner, child)


def _check_same(spec: mujoco.MjSpec, result: str) -> None:
    """Raise if the text does not compile to the model of the specification."""
    try:
        own, read = spec.copy().compile(), mujoco.MjModel.from_xml_string(result)
    except ValueError as error:
        raise FFGymError(f"Model {spec.modelname!r} cannot be written as MJCF: {error}.") from error
    if physics_fingerprint(own) != physics_fingerprint(read):
        names = [name for name in dir(own) if isinstance(getattr(own, name), np.ndarray | int | float)]
        changed = [name for name in names if not np.array_equal(getattr(own, name), getattr(read, name))]
        raise FFGymError(
            f"Model {spec.modelname!r} has parts that cannot be written exactly; they change "
            f"{', '.join(changed) or 'its names'}. Leave them out, or save it as .mjb."
        )
