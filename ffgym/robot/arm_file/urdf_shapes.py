"""Shapes of a URDF file as geoms without mass, and where meshes are."""

from collections.abc import Mapping
from pathlib import Path
from xml.etree import ElementTree as ET

import mujoco
import numpy as np
import scipy

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array

READABLE = (".stl", ".obj", ".msh")
"""Formats that MuJoCo reads."""

WAY_OUT = 'or leave the looks out: --no-looks of ffgym robot new, looks = "none" in [robot], looks=False in read_arm'
"""What helps against any trouble with a mesh."""


def numbers(element: ET.Element, attribute: str, what: str, default: tuple[float, ...]) -> Array:
    """As many numbers as `default` has from an attribute; `default` if it is not there.

    Raises:
        FFGymError: if they are not; `what` names the element.
    """
    text = element.get(attribute)
    if text is None:
        return np.array(default)
    try:
        values = np.array([float(word) for word in text.split()])
    except ValueError:
        values = np.empty(0)
    if len(values) != len(default) or not np.all(np.isfinite(values)):
        count = "a number" if len(default) == 1 else f"{len(default)} numbers"
        raise FFGymError(f"{what}: {attribute} = {text!r} must be {count}.")
    return values


def number(element: ET.Element, attribute: str, what: str, default: float) -> float:
    """One number from an attribute; `default` if it is not there.

    Raises:
        FFGymError: if it is none; `what` names the element.
    """
    return float(numbers(element, attribute, what, (default,))[0])


def find_mesh(uri: str, folder: Path, what: str) -> Path:
    """The file that `uri` means in a file that lies in `folder`.

    `package://name/rest` is looked for as `name/rest` in every folder that holds the file, `file:///place` is absolute;
    other relative paths start at `folder`.

    Raises:
        FFGymError: if there is no such file; `what` names the mesh.
    """
    places = _places(uri, folder)
    for place in places:
        if place.is_file():
            return place
    looked = ", ".join(map(str, places[:3])) + (f" and {len(places) - 3} folders above" if len(places) > 3 else "")
    raise FFGymError(f"The mesh {uri!r} of {what} is missing; looked for {looked}. Put it there, {WAY_OUT}.")


def _places(uri: str, folder: Path) -> list[Path]:
    _, scheme, rest = uri.partition("://")
    return [parent / rest for parent in (folder, *folder.parents)] if scheme else [folder / uri]


def without_mesh(spec: mujoco.MjSpec, mesh: mujoco.MjsMesh) -> str:
    """What helps if a mesh of MJCF is missing: without looks it does not matter, unless the mass of a body needs it."""
    bodies = [geom.parent.name for geom in spec.geoms if geom.meshname == mesh.name and weighs(spec, geom)]
    if not bodies:
        return WAY_OUT
    return f"or give body {bodies[0]!r} an <inertial>: its mass comes from this mesh"


def weighs(spec: mujoco.MjSpec, geom: mujoco.MjsGeom) -> bool:
    """Whether MuJoCo takes mass of a body from this geom."""
    rule = spec.compiler.inertiafromgeom
    if geom.mass == 0 or (np.isnan(geom.mass) and geom.density == 0):
        return False
    if rule == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_AUTO:
        return not geom.parent.explicitinertial
    return bool(rule == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE)


_GREY = (0.7, 0.7, 0.7, 1.0)
"""Colour of shapes without one."""


def add_shapes(
    spec: mujoco.MjSpec, root: ET.Element, shapes: Mapping[str, list[ET.Element]], folder: Path
) -> tuple[str, ...]:
    """Add the shapes of each link to its body; returns a note for every link that stays without.

    Raises:
        FFGymError: if a shape is none, or its mesh is missing.
    """
    notes = []
    parts = [root, *(element for elements in shapes.values() for element in elements)]
    materials = [material for part in parts for material in part.findall("material")]
    colours = {str(m.get("name")): m for m in materials if m.find("color") is not None}
    for link, elements in shapes.items():
        body = spec.body(link)
        drawable = _drawable(elements)
        if elements and not drawable:
            notes.append(f"link {link!r} is not drawn: its meshes are in formats other than {', '.join(READABLE)}")
        for element in drawable:
            _add_shape(spec, body, element, _colour(element, colours), folder)
    return tuple(notes)


def _drawable(elements: list[ET.Element]) -> list[ET.Element]:
    """All visual shapes if all of them can be read, else the collision shapes that can."""
    visual = [element for element in elements if element.tag == "visual"]
    if visual and all(map(_readable, visual)):
        return visual
    return [element for element in elements if element.tag == "collision" and _readable(element)] or list(
        filter(_readable, visual)
    )


def _readable(element: ET.Element) -> bool:
    mesh = element.find("geometry/mesh")
    return mesh is None or str(mesh.get("filename")).lower().endswith(READABLE)


def _add_shape(
    spec: mujoco.MjSpec, body: mujoco.MjsBody, element: ET.Element, colour: list[float], folder: Path
) -> None:
    what = f"link {body.name!r} {element.tag}"
    shape = element.find("geometry/*")
    if shape is None:
        raise FFGymError(f"{what}: has no geometry; it needs a box, cylinder, capsule, sphere or mesh.")
    origin = element.find("origin")
    origin = ET.Element("origin") if origin is None else origin
    form = _mesh(spec, shape, folder, what) if shape.tag == "mesh" else _primitive(shape, what)
    body.add_geom(
        pos=numbers(origin, "xyz", what, (0.0, 0.0, 0.0)),
        quat=quaternion(numbers(origin, "rpy", what, (0.0, 0.0, 0.0))),
        rgba=colour,
        mass=0.0,
        **form,
    )


def _primitive(shape: ET.Element, what: str) -> dict[str, object]:
    """Type and size of a geom."""
    nothing = float("nan")
    radius, half = number(shape, "radius", what, nothing), number(shape, "length", what, nothing) / 2
    sizes = {
        "box": (mujoco.mjtGeom.mjGEOM_BOX, numbers(shape, "size", what, (nothing,) * 3) / 2),
        "cylinder": (mujoco.mjtGeom.mjGEOM_CYLINDER, np.array([radius, half, 0])),
        "capsule": (mujoco.mjtGeom.mjGEOM_CAPSULE, np.array([radius, half, 0])),
        "sphere": (mujoco.mjtGeom.mjGEOM_SPHERE, np.array([radius, 0, 0])),
    }
    if shape.tag not in sizes:
        raise FFGymError(f"{what}: geometry is {shape.tag!r}, must be a mesh, {', '.join(sizes)}.")
    kind, size = sizes[shape.tag]
    if not np.all(size >= 0) or size[0] == 0:
        raise FFGymError(f"{what}: the {shape.tag} lacks a size [m] > 0.")
    return {"type": kind, "size": size}


def _mesh(spec: mujoco.MjSpec, shape: ET.Element, folder: Path, what: str) -> dict[str, object]:
    """Type and mesh of a geom; each use of a file is a mesh of its own, as its scale may differ."""
    path = find_mesh(str(shape.get("filename")), folder, what)
    mesh = spec.add_mesh(
        name=f"mesh{len(spec.meshes)}",
        file=str(path.absolute()),
        scale=numbers(shape, "scale", what, (1.0, 1.0, 1.0)),
        inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,  # also for a surface that is not closed
    )
    return {"type": mujoco.mjtGeom.mjGEOM_MESH, "meshname": mesh.name}


def _colour(element: ET.Element, named: Mapping[str, ET.Element]) -> list[float]:
    """Colour of a shape: its own, that of the file's material of this name, or grey."""
    material = element.find("material")
    if material is None:
        return list(_GREY)
    if material.find("color") is None:
        material = named.get(str(material.get("name")), material)
    colour = material.find("color")
    return list(_GREY) if colour is None else numbers(colour, "rgba", "color", _GREY).tolist()


def quaternion(rpy: Array) -> Array:
    """Unit quaternion, scalar first, of URDF's roll, pitch, yaw [rad] about the fixed axes x, y, z."""
    return scipy.spatial.transform.Rotation.from_euler("xyz", rpy).as_quat()[[3, 0, 1, 2]]
