"""The model of a robot as MJCF that compiles to the same model, bit for bit.

MuJoCo's own writer keeps 6 digits. This one writes what `build_spec` builds, with all digits, and compares the compiled
models before it returns, so that nothing is lost unseen.
"""

from textwrap import fill
from typing import Any
from xml.etree import ElementTree as ET

import mujoco
import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.robot.model.fingerprint import physics_fingerprint
from ffgym.robot.model.mjcf_elements import (
    actuator_element,
    element,
    inertial_element,
    key_element,
    tendon_element,
    text,
)

_COMMENTS = {
    "worldbody": "The arm, link side, in SI units. JOINT_motor moves by motor angle / gear ratio and carries rotor "
    "inertia, friction and servo; JOINT_deflection behind it is the elasticity, and carries the link. The position of "
    "the joint is their sum.",
    "tendon": "Angles of motors that several joints turn (fixed), springs between links (spatial).",
    "actuator": "The drives, motor side: gear is motor turns per joint turn, so that set-points, gains and torques are "
    "those of the motor. data.ctrl has position [rad], velocity [rad/s] and feed-forward torque [N m] of each servo. "
    "lugre is stiffness, damping, Coulomb and static torque, Stribeck velocity of the friction; damping is viscous.",
    "keyframe": "States of equilibrium to start from: springs and servo integrals carry the load.",
}
"""What a reader should know before a section."""

_INTEGRATORS = ("Euler", "RK4", "implicit", "implicitfast")
"""MJCF's words, in MuJoCo's order."""


def mjcf_text(spec: mujoco.MjSpec) -> str:
    """MJCF of a specification as `build_spec` makes it, before it is compiled; its `comment` stands on top.

    Raises:
        FFGymError: if the text would not compile to the same model, as the specification holds what robots do not.
    """
    root = ET.Element("mujoco", model=spec.modelname)
    ET.SubElement(root, "compiler", angle="degree" if spec.compiler.degree else "radian")
    root.append(_option(spec.option))
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
    assets, world = ET.Element("asset"), ET.Element("worldbody")
    for kind, parts in (("texture", spec.textures), ("material", spec.materials), ("mesh", spec.meshes)):
        assets.extend([element(kind, part) for part in parts])
    _fill(world, spec.worldbody)
    tendons, actuators, keys = (ET.Element(tag) for tag in ("tendon", "actuator", "keyframe"))
    tendons.extend([tendon_element(part) for part in spec.tendons])
    actuators.extend([actuator_element(part) for part in spec.actuators])
    keys.extend([key_element(part) for part in spec.keys])
    return [_visual(spec.visual), assets, world, tendons, actuators, keys]


def _fill(out: ET.Element, body: Any) -> None:
    """Add what belongs to a body, and the bodies behind it."""
    for kind, parts in (("joint", body.joints), ("geom", body.geoms), ("site", body.sites), ("light", body.lights)):
        out.extend([element(kind, part) for part in parts])
    for child in body.bodies:
        inner = ET.SubElement(out, "body", name=child.name)
        for name, unmoved in (("pos", [0, 0, 0]), ("quat", [1, 0, 0, 0])):
            if not np.array_equal(getattr(child, name), unmoved):
                inner.set(name, text(getattr(child, name)))
        inner.append(inertial_element(child))
        _fill(inner, child)


def _option(option: Any) -> ET.Element:
    """Step, integrator, gravity, and what is switched off."""
    integrator = _INTEGRATORS[option.integrator]
    out = ET.Element("option", timestep=text(option.timestep), integrator=integrator, gravity=text(option.gravity))
    for name, bit in mujoco.mjtDisableBit.__members__.items():
        if name.startswith("mjDSBL_") and option.disableflags & int(bit):
            flag = out[0] if len(out) else ET.SubElement(out, "flag")
            flag.set(name.removeprefix("mjDSBL_").lower(), "disable")
    return out


def _visual(visual: Any) -> ET.Element:
    """Light at the camera and clipping planes, where they are not MuJoCo's."""
    out, default = ET.Element("visual"), mujoco.MjSpec().visual
    for group in ("headlight", "map"):
        own, usual = getattr(visual, group), getattr(default, group)
        names = [name for name in dir(own) if not name.startswith("_")]
        changed = [name for name in names if not np.array_equal(getattr(own, name), getattr(usual, name))]
        if changed:
            ET.SubElement(out, group, {name: text(getattr(own, name)) for name in changed})
    return out


def _check_same(spec: mujoco.MjSpec, result: str) -> None:
    """Raise if the text does not compile to the model of the specification."""
    try:
        own, read = spec.copy().compile(), mujoco.MjModel.from_xml_string(result)
    except ValueError as error:
        raise FFGymError(f"Model {spec.modelname!r} cannot be written as MJCF: {error}.") from error
    if physics_fingerprint(own) != physics_fingerprint(read):
        raise FFGymError(
            f"Model {spec.modelname!r} has parts that cannot be written exactly; they change "
            f"{', '.join(_differences(own, read)) or 'its names'}. Leave them out, or save it as .mjb."
        )


def _differences(a: mujoco.MjModel, b: mujoco.MjModel) -> list[str]:
    """Names of the fields in which two models differ."""
    names = [name for name in dir(a) if isinstance(getattr(a, name), np.ndarray | int | float)]
    return [name for name in names if not np.array_equal(getattr(a, name), getattr(b, name))]
