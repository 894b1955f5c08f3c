"""URDF: checked as a tree of links and joints, then read by MuJoCo without its shapes."""

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from xml.etree import ElementTree as ET

import mujoco
import numpy as np

from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.types import Array
from ffgym.robot.arm_file.arm_file import Source
from ffgym.robot.arm_file.chain import HELD
from ffgym.robot.arm_file.urdf_shapes import add_shapes, number
from ffgym.robot.parts import point_mass_inertia

_ENTRIES = {"ixx": (0, 0), "iyy": (1, 1), "izz": (2, 2), "ixy": (0, 1), "ixz": (0, 2), "iyz": (1, 2)}

_ZERO = 1e-9
"""Principal moment over the largest one of the tensor that is still zero: rounding of its computation."""


def replace_zero_inertias(root: ET.Element) -> tuple[str, ...]:
    """Give links that weigh something the smallest inertia a body of theirs may have about axes where theirs is zero.

    Returns a note for each such link; what is negative or no number is left to whoever reads the file.
    """
    changed = [str(link.get("name")) for link in root.findall("link") if _replaced(link)]
    if not changed:
        return ()
    named = ", ".join(changed[:6]) + (f" and {len(changed) - 6} more" if len(changed) > 6 else "")
    return (
        f"the inertia of {named} is 0 about some axis, which is taken as not known; that of a ball of 10 mm radius "
        "stands there. links.inertia in the description replaces it",
    )


def _replaced(link: ET.Element) -> bool:
    element = link.find("inertial/inertia")
    try:
        mass, tensor = _mass(link), _tensor(element)
    except FFGymError:
        return False
    if element is None or not mass > 0:
        return False
    moments, axes = np.linalg.eigh(tensor)
    zero = np.abs(moments) <= _ZERO * np.abs(moments).max()
    if not zero.any() or (moments[~zero] < 0).any():
        return False
    short = 2 * moments.max() - moments[~zero].sum()  # of the sum that bodies have beside their largest moment
    least = max(point_mass_inertia(mass)[0], short / zero.sum())
    full = axes @ np.diag(np.where(zero, least, moments)) @ axes.T
    for name, place in _ENTRIES.items():
        element.set(name, repr(float(full[place])))
    return True


def _mass(link: ET.Element) -> float:
    element = link.find("inertial/mass")
    return 0.0 if element is None else number(element, "value", "mass", 0.0)


def _tensor(element: ET.Element | None) -> Array:
    tensor = np.zeros((3, 3))
    if element is None:
        return tensor
    for name, (row, column) in _ENTRIES.items():
        tensor[row, column] = tensor[column, row] = number(element, name, "inertia", 0.0)
    return tensor


_SERIAL = ("revolute", "continuous", "prismatic", "fixed")
"""Joint types that a serial arm may have."""
_OTHERS = ("planar", "floating", "spherical")
"""Joint types that are held still, if at all."""
_NO_MASSES = (
    "the file has no masses (inertial) at all; links.mass, links.com and links.inertia have to come from elsewhere"
)
"""What is said of a file that is geometry alone."""


def read_urdf(data: bytes, folder: Path, joints: Sequence[str] | None, *, looks: bool) -> Source:
    """Read URDF from the bytes of a file in `folder`; planar and floating joints that are not in `joints` are fixed."""
    try:
        root = ET.fromstring(data)
    except (ET.ParseError, ValueError, LookupError) as error:  # LookupError: an encoding that Python does not know
        raise FFGymError(f"It is not valid XML: {error}.") from error
    _check_expanded(root)
    _check_tree(root)
    for joint in root.findall("joint"):
        _check_limits(joint)
        _hold_if_unfit(joint, joints)
    speeds, ratios = _speeds(root), _gear_ratios(root)
    shapes = _without_shapes(root)
    has_masses = root.find("link/inertial") is not None
    if not has_masses:
        _stand_in_for_masses(root)
    inertias = replace_zero_inertias(root)
    spec = mujoco.MjSpec.from_string(ET.tostring(root, encoding="unicode"))
    notes = add_shapes(spec, root, shapes, folder) if looks else ()
    return Source(
        spec=spec,
        speeds=speeds,
        gear_ratios=ratios,
        has_masses=has_masses,
        notes=(*(() if has_masses else (_NO_MASSES,)), *inertias, *notes),
    )


def _stand_in_for_masses(root: ET.Element) -> None:
    """Give every link some mass, without which MuJoCo moves nothing; whoever reads the model leaves it out."""
    for link in root.findall("link"):
        inertial = ET.SubElement(link, "inertial")
        ET.SubElement(inertial, "mass", value="1")
        ET.SubElement(inertial, "inertia", ixx="1", iyy="1", izz="1", ixy="0", ixz="0", iyz="0")


def _check_expanded(root: ET.Element) -> None:
    if any(isinstance(element.tag, str) and "xacro" in element.tag.split("}")[0] for element in root.iter()):
        raise FFGymError("It is a xacro file, a template of URDF. Expand it first: xacro arm.urdf.xacro > arm.urdf.")


def _check_tree(root: ET.Element) -> None:
    """Every link but one hangs on one joint, and all hang together."""
    links = [link.get("name") for link in root.findall("link")]
    joints = root.findall("joint")
    for what, names in (("link", links), ("joint", [joint.get("name") for joint in joints])):
        twice = [name for name, count in Counter(names).items() if count > 1 or not name]
        if twice:
            raise FFGymError(f"Every {what} needs a name of its own, but there is {twice[0]!r} twice or without one.")
    if not links:
        raise FFGymError("It has no links.")
    parents: dict[str, str] = {}
    for joint in joints:
        parent, child = (_end(joint, end, links) for end in ("parent", "child"))
        if child in parents:
            raise FFGymError(
                f"Link {child!r} has two parents, {parents[child]!r} and {parent!r}: a closed loop. Only serial arms "
                f"can be described; remove the joint that closes it. A counterbalance can be an entry of [springs]."
            )
        parents[child] = parent
    roots = [str(link) for link in links if link not in parents]
    if len(roots) != 1:
        raise FFGymError(
            f"It has {len(roots)} links without a parent, {roots}; a robot has one root, from which all links hang."
            + (" Its joints form a loop; remove one." if not roots else "")
        )
    _check_reached(parents)


def _end(joint: ET.Element, end: str, links: Sequence[str | None]) -> str:
    """Name of the parent or child link of a joint."""
    element = joint.find(end)
    name = None if element is None else element.get("link")
    if name is None or name not in links:
        raise FFGymError(f"Joint {joint.get('name')!r}: its {end} is {name!r}, which is no link of the file.")
    return name


def _check_reached(parents: dict[str, str]) -> None:
    for link in parents:
        seen = [link]
        while seen[-1] in parents:
            seen.append(parents[seen[-1]])
            if seen[-1] == link:
                raise FFGymError(f"Links {seen} hang on each other in a loop; a robot has one root. Remove a joint.")
            if len(seen) > len(parents) + 1:
                break  # runs into a loop further up, which is reported for a link of its own


def _check_limits(joint: ET.Element) -> None:
    limit = joint.find("limit")
    if limit is None:
        return
    low, high = (number(limit, name, f"joint {joint.get('name')!r} limit", 0.0) for name in ("lower", "upper"))
    if low > high:
        raise FFGymError(f"Joint {joint.get('name')!r}: limit lower = {low} is above upper = {high}.")


def _hold_if_unfit(joint: ET.Element, wanted: Sequence[str] | None) -> None:
    name = str(joint.get("name"))
    kind = check_choice(f"type of joint {name!r}", str(joint.get("type")), _SERIAL + _OTHERS)
    if kind in _SERIAL:
        return
    if wanted is None or name in wanted:
        raise FFGymError(f"Joint {name!r} is {kind}; an arm has revolute, continuous and prismatic joints. {HELD}")
    joint.set("type", "fixed")


def _speeds(root: ET.Element) -> dict[str, float]:
    """Speed limits [rad/s] or [m/s]; 0, which many files say, is none."""
    speeds = {}
    for joint in root.findall("joint"):
        limit, name = joint.find("limit"), str(joint.get("name"))
        speed = 0.0 if limit is None else number(limit, "velocity", f"joint {name!r} limit", 0.0)
        if speed > 0:
            speeds[name] = speed
    return speeds


def _gear_ratios(root: ET.Element) -> dict[str, float]:
    """Gear ratios of transmissions; 1, which most files say of any gearbox, is none."""
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


def _without_shapes(root: ET.Element) -> dict[str, list[ET.Element]]:
    """Take the shapes out of all links: they weigh nothing in URDF, and MuJoCo would derive masses from them."""
    shapes: dict[str, list[ET.Element]] = {}
    for link in root.findall("link"):
        found = [element for element in link if element.tag in ("visual", "collision")]
        for element in found:
            link.remove(element)
        shapes[str(link.get("name"))] = found
    return shapes
