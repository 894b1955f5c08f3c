"""Extent of an MJCF file before MuJoCo reads it: how many elements it stands for, and that its files are files."""

import re
from collections.abc import Iterator
from math import prod
from pathlib import Path
from xml.etree import ElementTree as ET

import mujoco
import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.files import check_ordinary, is_file

MOST_ELEMENTS = 100_000
"""Elements that an arm file may stand for; chosen: a thousand times an arm with its shapes. MuJoCo would copy on."""

_COPIED = ("replicate", "composite", "flexcomp")
"""Elements whose `count` stands for copies."""
_GRIDS = {"hfield": ("nrow", "ncol"), "texture": ("width", "height")}
"""Elements for whose numbers MuJoCo reserves memory."""
_MOST_NUMBERS = 10**7
"""Numbers that one of these may have; chosen: a picture of 3000 x 3000."""

_ATTRIBUTE = r"""\b{}\s*=\s*["']([^"']*)["']"""
"""Pattern of an attribute by name; its group is the value."""


LONGEST = 1e6
"""Longest length of an arm file [m]; chosen: a thousand kilometres."""
_FLAT = 1e-9
"""Thickness over length below which a mesh is flat."""


def check_lengths(spec: mujoco.MjSpec) -> None:
    """Check places and sizes of a parsed file, of which MuJoCo computes products.

    Raises:
        FFGymError: if one is longer than LONGEST, or a mesh whose vertices stand in the file is flat.
    """
    found = [("body", body.pos) for body in spec.bodies]
    found += [("geom", np.concatenate([geom.pos, geom.size, geom.fromto])) for geom in spec.geoms]
    for mesh in spec.meshes:
        points = np.reshape(mesh.uservert, (-1, 3)) * mesh.scale
        found.append(("mesh", points))
        if len(points) > 3 and np.all(np.abs(points) <= LONGEST):
            thickness = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
            if thickness[2] <= _FLAT * thickness[0]:
                raise FFGymError("A mesh is flat; its points must span a volume.")
    for what, values in found:
        longest = np.abs(np.where(np.isnan(values), 0.0, values)).max(initial=0.0)
        if longest > LONGEST:
            raise FFGymError(f"A {what} has a length of {longest:g} m, must be {LONGEST:g} m at most. Is it in mm?")


def check_extent(path: Path) -> None:
    """Check an MJCF file and what it includes.

    Raises:
        FFGymError: if it stands for more than MOST_ELEMENTS elements, has a grid that is too large, or a pipe or a
            device is in the place of a file.
    """
    total = 0
    for file, text in _files(path):
        total += _count(text)
        if total > MOST_ELEMENTS:
            raise FFGymError(
                f"{file.name} stands for more than {MOST_ELEMENTS} elements, counted with the copies of "
                f"{', '.join(_COPIED)}. Is a count wrong? An arm has some hundred."
            )
        folders = ["", *re.findall(_ATTRIBUTE.format("(?:mesh|asset|texture)dir"), text)]
        for name in re.findall(_ATTRIBUTE.format("file"), text):
            for folder in folders:
                check_ordinary(path.parent / folder / name)


def _files(path: Path) -> Iterator[tuple[Path, str]]:
    """Find the file and those that it includes, with their texts; MuJoCo looks for them beside the first one."""
    waiting, seen = [path], set()
    while waiting:
        file = waiting.pop()
        if file in seen or not is_file(file):  # MuJoCo says that it is missing
            continue
        seen.add(file)
        text = file.read_bytes().decode("latin-1")
        yield file, text
        waiting += [path.parent / name for name in re.findall(r"<include\s+" + _ATTRIBUTE.format("file"), text)]


def _count(text: str) -> int:
    """Count elements with their copies; where the text is no XML, the most that they can be."""
    try:
        root = ET.fromstring(text)
    except (ET.ParseError, ValueError, LookupError):  # which MuJoCo refuses, or reads differently
        copies = re.findall(rf"<(?:{'|'.join(_COPIED)})\b[^>]*?" + _ATTRIBUTE.format("count"), text)
        return text.count("<") * prod(map(_copies, copies))
    total = 0
    waiting = [(root, 1)]
    while waiting:
        element, factor = waiting.pop()
        total += factor
        if element.tag in _COPIED:
            factor *= _copies(element.get("count", ""))
            total += factor
        elif element.tag in _GRIDS:
            _check_grid(element)
        if total > MOST_ELEMENTS:
            break
        waiting += [(child, factor) for child in element]
    return total


def _check_grid(element: ET.Element) -> None:
    names = _GRIDS[element.tag]
    size = prod(_copies(element.get(name, "")) for name in names)
    if size > _MOST_NUMBERS:
        raise FFGymError(
            f"{element.tag} {element.get('name')!r}: {' x '.join(names)} is {size}, must be {_MOST_NUMBERS} at most."
        )


def _copies(text: str) -> int:
    """Number of copies that a count of one or several numbers stands for; 1 where it is none, as MuJoCo says so."""
    try:
        numbers = [max(int(float(word)), 1) for word in text.split()]
    except (ValueError, OverflowError):
        return 1
    return min(prod(numbers), 10**12)
