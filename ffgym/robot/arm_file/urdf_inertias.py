"""Inertias of URDF links that stand in the file as zero: numbers that nobody knew, or that were rounded away."""

from xml.etree import ElementTree as ET

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.robot.arm_file.xml_numbers import number
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
