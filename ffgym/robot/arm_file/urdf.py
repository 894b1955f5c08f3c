"""URDF: checked as a tree of links and joints, then read by MuJoCo without its shapes."""

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from xml.etree import ElementTree as ET

import mujoco
import numpy as np

from ffgym.core.errors import FFGymError, check_choice
from ffgym.robot.arm_file.arm_file import Source
from ffgym.robot.arm_file.chain import HELD
from ffgym.robot.arm_file.shapes import add_shapes, number
from ffgym.robot.parts import point_mass_inertia

_ENTRIES = {"ixx": (0, 0), "iyy": (1, 1), "izz": (2, 2), "ixy": (0, 1), "ixz": (0, 2), "iyz": (1, 2)}

_ZERO = 1e-9
"""Principal moment over the largest one of the tensor that is still zero: rounding of its computation."""
_SERIAL = ("revolute", "continuous", "prismatic", "fixed")
"""Joint types that a serial arm may have."""
_OTHERS = ("planar", "floating", "spherical")
"""Joint types that are held still, if at all."""
_NO_MASSES = (
    "the file has no masses (inertial) at all; links.mass, links.com and links.inertia have to come from elsewhere"
)
"""Note on a file that is geometry alone."""


def read_urdf(data: bytes, folder: Path, joints: Sequence[str] | None, *, looks: bool) -> Source:
    """Read URDF from the bytes of a file in `folder`; planar and floating joints that are not in `joints` are fixed."""
    try:
        root = ET.fromstring(data)
    except (ET.ParseError, ValueError, LookupError) as error:  # LookupError: an encoding that Python does not know
        raise FFGymError(f"It is not valid XML: {error}.") from error
    if any(isinstance(element.tag, str) and "xacro" in element.tag.split("}")[0] for element in root.iter()):
        raise FFGymError("It is a xacro file, a template of URDF. Expand it first: xacro arm.urdf.xacro > arm.urdf.")
    _check_tree(root)
    for joint in root.findall("joint"):
        _check_joint(joint, joints)
    # speed limits [rad/s] or [m/s]; 0, which many files say, is none
    limits = {str(joint.get("name")): joint.find("limit") for joint in root.findall("joint")}
    speeds = {
        name: number(limit, "velocity", f"joint {name!r} limit", 0.0)
        for name, limit in limits.items()
        if limit is not None
    }
    ratios = _gear_ratios(root)
    # take the shapes out of all links: they weigh nothing in URDF, and MuJoCo would derive masses from them
    shapes: dict[str, list[ET.Element]] = {}
    for link in root.findall("link"):
        shapes[str(link.get("name"))] = [element for element in link if element.tag in ("visual", "collision")]
        for element in shapes[str(link.get("name"))]:
            link.remove(element)
    # give every link some mass, without which MuJoCo moves nothing; whoever reads the model leaves it out
    has_masses = root.find("link/inertial") is not None
    for link in root.findall("link") if not has_masses else ():
        inertial = ET.SubElement(link, "inertial")
        ET.SubElement(inertial, "mass", value="1")
        ET.SubElement(inertial, "inertia", ixx="1", iyy="1", izz="1", ixy="0", ixz="0", iyz="0")
    # remark on what was replaced, as results depend on it
    notes = [] if has_masses else [_NO_MASSES]
    changed = [str(link.get("name")) for link in root.findall("link") if _replace_zero_inertia(link)]
    if changed:
        named = ", ".join(changed[:6]) + (f" and {len(changed) - 6} more" if len(changed) > 6 else "")
        notes.append(
            f"the inertia of {named} is 0 about some axis, which is taken as not known; that of a ball of 10 mm "
            "radius stands there. links.inertia in the description replaces it",
        )
    spec = mujoco.MjSpec.from_string(ET.tostring(root, encoding="unicode"))
    return Source(
        spec=spec,
        speeds={name: speed for name, speed in speeds.items() if speed > 0},
        gear_ratios=ratios,
        has_masses=has_masses,
        notes=(*notes, *(add_shapes(spec, root, shapes, folder) if looks else ())),
    )


def _check_tree(root: ET.Element) -> None:
    """Check that every link but one hangs on one joint, and all are connected."""
    links = [link.get("name") for link in root.findall("link")]
    joints = root.findall("joint")
    # unique names, by which joints refer to links
    for what, names in (("link", links), ("joint", [joint.get("name") for joint in joints])):
        twice = [name for name, count in Counter(names).items() if count > 1 or not name]
        if twice:
            raise FFGymError(f"Every {what} needs a name of its own, but there is {twice[0]!r} twice or without one.")
    if not links:
        raise FFGymError("It has no links.")
    # parent of each link; a second one closes a loop
    parents: dict[str, str] = {}
    for joint in joints:
        ends: dict[str, str] = {}
        for end in ("parent", "child"):
            element = joint.find(end)
            name = None if element is None else element.get("link")
            if name is None or name not in links:
                raise FFGymError(f"Joint {joint.get('name')!r}: its {end} is {name!r}, which is no link of the file.")
            ends[end] = name
        parent, child = ends["parent"], ends["child"]
        if child in parents:
            raise FFGymError(
                f"Link {child!r} has two parents, {parents[child]!r} and {parent!r}: a closed loop. Only serial arms "
                f"can be described; remove the joint that closes it. A counterbalance can be an entry of [springs]."
            )
        parents[child] = parent
    # one root, as an arm stands on one base
    roots = [str(link) for link in links if link not in parents]
    if len(roots) != 1:
        raise FFGymError(
            f"It has {len(roots)} links without a parent, {roots}; a robot has one root, from which all links hang."
            + (" Its joints form a loop; remove one." if not roots else "")
        )
    # loops apart from the root: follow parents of each link until they end
    for link in parents:
        seen = [link]
        while seen[-1] in parents and len(seen) <= len(parents) + 1:  # a loop further up is that of a link of its own
            seen.append(parents[seen[-1]])
            if seen[-1] == link:
                raise FFGymError(f"Links {seen} hang on each other in a loop; a robot has one root. Remove a joint.")


def _check_joint(joint: ET.Element, wanted: Sequence[str] | None) -> None:
    """Check limits and type of a joint, and hold it still if it is none of a serial arm."""
    name, limit = str(joint.get("name")), joint.find("limit")
    if limit is not None:
        low, high = (number(limit, end, f"joint {joint.get('name')!r} limit", 0.0) for end in ("lower", "upper"))
        if low > high:
            raise FFGymError(f"Joint {joint.get('name')!r}: limit lower = {low} is above upper = {high}.")
    kind = check_choice(f"type of joint {name!r}", str(joint.get("type")), _SERIAL + _OTHERS)
    if kind in _SERIAL:
        return
    if wanted is None or name in wanted:
        raise FFGymError(f"Joint {name!r} is {kind}; an arm has revolute, continuous and prismatic joints. {HELD}")
    joint.set("type", "fixed")


def _gear_ratios(root: ET.Element) -> dict[str, float]:
    """Read gear ratios of transmissions; 1 is ignored, as most files have it for any gearbox."""
    ratios = {}
    for transmission in root.findall("transmission"):
        joints, reduction = transmission.findall("joint"), transmission.find(".//mechanicalReduction")
        if len(joints) != 1 or reduction is None:
            continue
        name = str(joints[0].get("name"))
        try:
            ratio = float(reduction.text or "")
        except ValueError as error:
            raise FFGymError(
                f"mechanicalReduction of joint {name!r} is {reduction.text!r}, must be a number."
            ) from error
        if ratio not in (0.0, 1.0):
            ratios[name] = ratio
    return ratios


def _replace_zero_inertia(link: ET.Element) -> bool:
    """Give a link that weighs something the smallest inertia a body of its may have about axes where its is zero.

    Returns whether it did; what is negative or no number is left to whoever reads the file.
    """
    element, weight, tensor = link.find("inertial/inertia"), link.find("inertial/mass"), np.zeros((3, 3))
    if element is None or weight is None:
        return False
    try:
        mass = number(weight, "value", "mass", 0.0)
        for name, (row, column) in _ENTRIES.items():
            tensor[row, column] = tensor[column, row] = number(element, name, "inertia", 0.0)
    except FFGymError:
        return False
    moments, axes = np.linalg.eigh(tensor)
    zero = np.abs(moments) <= _ZERO * np.abs(moments).max()
    if not mass > 0 or not zero.any() or (moments[~zero] < 0).any():
        return False
    short = 2 * moments.max() - moments[~zero].sum()  # of the sum that bodies have beside their largest moment
    least = max(point_mass_inertia(mass)[0], short / zero.sum())
    full = axes @ np.diag(np.where(zero, least, moments)) @ axes.T
    for name, place in _ENTRIES.items():
        element.set(name, repr(float(full[place])))
    return True
