"""Geoms of a compiled model as the looks of a description."""

from collections.abc import Sequence

import mujoco
import numpy as np

from ffgym.core.types import Array
from ffgym.robot.arm_file.chain import BASE
from ffgym.robot.arm_file.measure import Pose
from ffgym.robot.shapes import Geom, Mesh

_KINDS = {
    mujoco.mjtGeom.mjGEOM_SPHERE.value: "sphere",
    mujoco.mjtGeom.mjGEOM_CAPSULE.value: "capsule",
    mujoco.mjtGeom.mjGEOM_ELLIPSOID.value: "ellipsoid",
    mujoco.mjtGeom.mjGEOM_CYLINDER.value: "cylinder",
    mujoco.mjtGeom.mjGEOM_BOX.value: "box",
    mujoco.mjtGeom.mjGEOM_MESH.value: "mesh",
}
"""Shapes that descriptions have, too."""

_SIZES = {"sphere": 1, "capsule": 1, "ellipsoid": 3, "cylinder": 1, "box": 3, "mesh": 0}
"""How many sizes each shape has here; the length of cylinders and capsules is in their end points."""

_SHOWN_GROUPS = 3
"""Groups below this are what MuJoCo's viewer shows; collision shapes usually stand in group 3."""


def looks_of(pose: Pose, links: Sequence[str]) -> tuple[Geom, ...]:
    """Geoms of the base and the links: the ones that touch nothing if there are any, else all."""
    model, chain = pose.model, pose.chain
    meshes = {int(i): _mesh(model, int(i)) for i in {*model.geom_dataid[_drawn(model)]} if i >= 0}
    geoms: list[Geom] = []
    for owner, body in enumerate(("base", *links), start=BASE):
        own = [g for g in _drawn(model) if chain.owner[model.geom_bodyid[g]] == owner]
        geoms += [_geom(pose, g, owner, body, meshes) for g in _preferred(model, own)]
    return tuple(geoms)


def _drawn(model: mujoco.MjModel) -> list[int]:
    return [g for g in range(model.ngeom) if model.geom_type[g] in _KINDS]


def _preferred(model: mujoco.MjModel, geoms: list[int]) -> list[int]:
    shown = [g for g in geoms if model.geom_group[g] < _SHOWN_GROUPS]
    visual = [g for g in shown if model.geom_contype[g] == 0 and model.geom_conaffinity[g] == 0]
    return visual or shown or geoms


def _geom(pose: Pose, g: int, owner: int, body: str, meshes: dict[int, Mesh]) -> Geom:
    model, data = pose.model, pose.data
    kind = _KINDS[model.geom_type[g]]
    centre, turn = data.geom_xpos[g] - pose.origin(owner), data.geom_xmat[g].reshape(3, 3)
    long = kind in ("cylinder", "capsule")
    half = turn[:, 2] * model.geom_size[g, 1] if long else np.zeros(3)
    quat = np.zeros(4)
    mujoco.mju_mat2Quat(quat, data.geom_xmat[g])
    return Geom(
        body=body,
        type=kind,
        size=tuple(model.geom_size[g, : _SIZES[kind]].tolist()),
        pos=_triple(centre - half),
        end=_triple(centre + half) if long else None,
        colour=_colour(model, g),
        rotation=(1.0, 0.0, 0.0, 0.0) if long else (*_triple(quat), float(quat[3])),
        mesh=meshes[int(model.geom_dataid[g])] if kind == "mesh" else None,
    )


def _triple(numbers: Array) -> tuple[float, float, float]:
    """The first three as plain numbers."""
    return float(numbers[0]), float(numbers[1]), float(numbers[2])


def _colour(model: mujoco.MjModel, g: int) -> tuple[float, ...]:
    material = model.geom_matid[g]
    rgba = model.geom_rgba[g] if material < 0 else model.mat_rgba[material]
    return tuple(float(x) for x in rgba)


def _mesh(model: mujoco.MjModel, mesh: int) -> Mesh:
    vertices = slice(model.mesh_vertadr[mesh], model.mesh_vertadr[mesh] + model.mesh_vertnum[mesh])
    faces = slice(model.mesh_faceadr[mesh], model.mesh_faceadr[mesh] + model.mesh_facenum[mesh])
    return Mesh(vertices=model.mesh_vert[vertices].copy(), faces=model.mesh_face[faces].copy())
