"""Shapes of an arm: those of a URDF file as geoms without mass, where meshes are, and the looks of a compiled model."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from xml.etree import ElementTree as ET

import mujoco
import numpy as np
import scipy

from ffgym.core.errors import FFGymError
from ffgym.core.files import check_ordinary, is_file
from ffgym.core.types import Array
from ffgym.robot.arm_file.chain import BASE
from ffgym.robot.arm_file.measure import ZeroPose
from ffgym.robot.model.looks import GEOM_TYPES
from ffgym.robot.parts import Geom, Mesh

READABLE = (".stl", ".obj", ".msh")
"""Formats that MuJoCo reads."""

WAY_OUT = 'or leave the looks out: --no-looks of ffgym robot new, looks = "none" in [robot], looks=False in read_arm'
"""Advice on any trouble with a mesh."""


def numbers(element: ET.Element, attribute: str, what: str, default: tuple[float, ...]) -> Array:
    """Read as many numbers as `default` has from an attribute; `default` if it is absent."""
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
    """Read one number from an attribute, `default` if it is not there; `what` names the element in errors."""
    return float(numbers(element, attribute, what, (default,))[0])


def find_mesh(uri: str, folder: Path, what: str) -> Path:
    """Find the file that `uri` means in a file of `folder`; an error names the mesh `what`.

    `package://name/rest` is looked for as `name/rest` in every folder that holds the file, `file:///place` is absolute;
    other relative paths start at `folder`.
    """
    _, scheme, rest = uri.partition("://")
    places = [parent / rest for parent in (folder, *folder.parents)] if scheme else [folder / uri]
    for place in places:
        check_ordinary(place)
        if is_file(place):
            return place
    looked = ", ".join(map(str, places[:3])) + (f" and {len(places) - 3} folders above" if len(places) > 3 else "")
    raise FFGymError(f"The mesh {uri!r} of {what} is missing; looked for {looked}. Put it there, {WAY_OUT}.")


def weighs(spec: mujoco.MjSpec, geom: mujoco.MjsGeom) -> bool:
    """Tell if MuJoCo takes mass of a body from this geom."""
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
    """Add the shapes of each link to its body; returns a note for every link that stays without."""
    notes = []
    parts = [root, *(element for elements in shapes.values() for element in elements)]
    materials = [material for part in parts for material in part.findall("material")]
    colours = {str(m.get("name")): m for m in materials if m.find("color") is not None}
    for link, elements in shapes.items():
        # all visual shapes if all of them can be read, else the collision shapes that can
        visual = [element for element in elements if element.tag == "visual"]
        drawable = list(filter(_readable, visual))
        if not visual or drawable != visual:
            drawable = [x for x in elements if x.tag == "collision" and _readable(x)] or drawable
        if elements and not drawable:
            notes.append(f"link {link!r} is not drawn: its meshes are in formats other than {', '.join(READABLE)}")
        for element in drawable:
            _add_shape(spec, spec.body(link), element, colours, folder)
    return tuple(notes)


def _readable(element: ET.Element) -> bool:
    mesh = element.find("geometry/mesh")
    return mesh is None or str(mesh.get("filename")).lower().endswith(READABLE)


def _add_shape(
    spec: mujoco.MjSpec, body: mujoco.MjsBody, element: ET.Element, colours: Mapping[str, ET.Element], folder: Path
) -> None:
    what = f"link {body.name!r} {element.tag}"
    shape = element.find("geometry/*")
    if shape is None:
        raise FFGymError(f"{what}: has no geometry; it needs a box, cylinder, capsule, sphere or mesh.")
    # pose of the shape in its link; without one, that of the link
    origin = element.find("origin")
    origin = ET.Element("origin") if origin is None else origin
    if shape.tag == "mesh":  # each use of a file is a mesh of its own, as its scale may differ
        mesh = spec.add_mesh(
            name=f"mesh{len(spec.meshes)}",
            file=str(find_mesh(str(shape.get("filename")), folder, what).absolute()),
            scale=numbers(shape, "scale", what, (1.0, 1.0, 1.0)),
            inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,  # also for a surface that is not closed
        )
        form = {"type": mujoco.mjtGeom.mjGEOM_MESH, "meshname": mesh.name}
    else:
        form = _primitive(shape, what)
    rpy = numbers(origin, "rpy", what, (0.0, 0.0, 0.0))  # about the fixed axes x, y, z [rad]
    # its own colour, that of the file's material of this name, or grey
    material = element.find("material")
    if material is not None and material.find("color") is None:
        material = colours.get(str(material.get("name")))
    colour = None if material is None else material.find("color")
    body.add_geom(
        pos=numbers(origin, "xyz", what, (0.0, 0.0, 0.0)),
        quat=scipy.spatial.transform.Rotation.from_euler("xyz", rpy).as_quat(scalar_first=True),
        rgba=_GREY if colour is None else numbers(colour, "rgba", "color", _GREY).tolist(),
        mass=0.0,
        **form,
    )


def _primitive(shape: ET.Element, what: str) -> dict[str, object]:
    """Read type and size of a geom."""
    nothing = float("nan")
    radius, half = number(shape, "radius", what, nothing), number(shape, "length", what, nothing) / 2
    sizes = {
        "box": numbers(shape, "size", what, (nothing,) * 3) / 2,
        "cylinder": np.array([radius, half, 0]),
        "capsule": np.array([radius, half, 0]),
        "sphere": np.array([radius, 0, 0]),
    }
    if shape.tag not in sizes:
        raise FFGymError(f"{what}: geometry is {shape.tag!r}, must be a mesh, {', '.join(sizes)}.")
    size = sizes[shape.tag]
    if not np.all(size >= 0) or size[0] == 0:
        raise FFGymError(f"{what}: the {shape.tag} lacks a size [m] > 0.")
    return {"type": GEOM_TYPES[shape.tag], "size": size}


_KINDS = {kind.value: name for name, kind in GEOM_TYPES.items()}
"""Shapes that descriptions have, by MuJoCo's numbers."""

_SIZES = {"sphere": 1, "capsule": 1, "ellipsoid": 3, "cylinder": 1, "box": 3, "mesh": 0}
"""Number of sizes of each shape; the length of cylinders and capsules is in their end points."""

_SHOWN_GROUPS = 3
"""Groups below this are what MuJoCo's viewer shows; collision shapes usually stand in group 3."""


def looks_of(pose: ZeroPose, links: Sequence[str]) -> tuple[Geom, ...]:
    """Collect geoms of the base and the links: those without contacts if there are any, else all."""
    model = pose.model
    drawn = [g for g in range(model.ngeom) if model.geom_type[g] in _KINDS]
    meshes = {}
    for mesh in {int(i) for i in model.geom_dataid[drawn] if i >= 0}:
        vertices = slice(model.mesh_vertadr[mesh], model.mesh_vertadr[mesh] + model.mesh_vertnum[mesh])
        faces = slice(model.mesh_faceadr[mesh], model.mesh_faceadr[mesh] + model.mesh_facenum[mesh])
        meshes[mesh] = Mesh(vertices=model.mesh_vert[vertices].copy(), faces=model.mesh_face[faces].copy())
    geoms: list[Geom] = []
    for owner, body in enumerate(("base", *links), start=BASE):
        own = [g for g in drawn if pose.chain.owner[model.geom_bodyid[g]] == owner]
        shown = [g for g in own if model.geom_group[g] < _SHOWN_GROUPS]
        visual = [g for g in shown if model.geom_contype[g] == 0 and model.geom_conaffinity[g] == 0]
        geoms += [_geom(pose, g, owner, body, meshes) for g in visual or shown or own]
    return tuple(geoms)


def _geom(pose: ZeroPose, g: int, owner: int, body: str, meshes: Mapping[int, Mesh]) -> Geom:
    model, data = pose.model, pose.data
    kind, material = _KINDS[model.geom_type[g]], model.geom_matid[g]
    centre, turn = data.geom_xpos[g] - pose.origin(owner), data.geom_xmat[g].reshape(3, 3)
    long = kind in ("cylinder", "capsule")
    half = turn[:, 2] * model.geom_size[g, 1] if long else np.zeros(3)
    quat = np.zeros(4)
    mujoco.mju_mat2Quat(quat, data.geom_xmat[g])
    w, x, y, z = quat.tolist()
    return Geom(
        body=body,
        type=kind,
        size=tuple(model.geom_size[g, : _SIZES[kind]].tolist()),
        pos=tuple((centre - half).tolist()),
        end=tuple((centre + half).tolist()) if long else None,
        colour=tuple((model.geom_rgba[g] if material < 0 else model.mat_rgba[material]).tolist()),
        rotation=(1.0, 0.0, 0.0, 0.0) if long else (w, x, y, z),
        mesh=meshes[int(model.geom_dataid[g])] if kind == "mesh" else None,
    )
