"""Looks of a robot: primitives and meshes or a stick figure, a floor, a sky and light."""

from typing import Any

import mujoco
import numpy as np

from ffgym.robot.description import RobotDescription
from ffgym.robot.parts import Geom

THICKNESS = 0.02
"""Radius of a rod over the length of the whole chain; chosen: as slender as an arm with its castings."""
_SHORTEST = 0.1
"""Rods shorter than this share of their radius are left out: their joints' balls cover them."""
ROD = (0.55, 0.6, 0.66, 1.0)
BALL = (0.25, 0.3, 0.36, 1.0)
"""Colours: red, green, blue, opacity."""


def stick_figure(robot: RobotDescription) -> tuple[Geom, ...]:
    """Shapes of a robot, made of the positions of its joints and its tool."""
    ends = dict(zip(("base", *robot.links), robot.kinematics.position, strict=False))
    ends[robot.links[-1]] = robot.bodies.com[-1] if robot.tool is None else robot.tool.position
    if robot.tool is not None:
        ends["tool"] = robot.tool.tcp
    length = sum(float(np.linalg.norm(end)) for end in ends.values())
    radius = THICKNESS * (length or 1.0)
    origin = (0.0, 0.0, 0.0)
    rods = [
        Geom(body=body, type="capsule", size=(radius,), pos=origin, end=tuple(end.tolist()), colour=ROD)
        for body, end in ends.items()
        if np.linalg.norm(end) > _SHORTEST * radius
    ]
    balls = [
        Geom(body=link, type="sphere", size=(1.5 * radius,), pos=origin, end=None, colour=BALL) for link in robot.links
    ]
    return (*rods, *balls)


GEOM_TYPES = {
    "box": mujoco.mjtGeom.mjGEOM_BOX,
    "cylinder": mujoco.mjtGeom.mjGEOM_CYLINDER,
    "capsule": mujoco.mjtGeom.mjGEOM_CAPSULE,
    "sphere": mujoco.mjtGeom.mjGEOM_SPHERE,
    "ellipsoid": mujoco.mjtGeom.mjGEOM_ELLIPSOID,
    "mesh": mujoco.mjtGeom.mjGEOM_MESH,
}
"""Shapes that descriptions have, as MuJoCo calls them."""


def add_looks(spec: mujoco.MjSpec, robot: RobotDescription) -> None:
    """Add the shapes of the description, a floor, a sky and light; they weigh nothing and touch nothing.

    A robot whose description has no shapes is drawn as a stick figure.
    """
    there = [geom for geom in robot.geoms if geom.body != "tool" or robot.tool is not None]  # a draft may lack its tool
    geoms = there or stick_figure(robot)
    # meshes, each once however many shapes use it
    meshes = {geom.mesh: f"mesh{i}" for i, geom in enumerate(geoms) if geom.mesh is not None}
    for mesh, name in meshes.items():
        spec.add_mesh(
            name=name,
            uservert=mesh.vertices.ravel(),
            userface=mesh.faces.ravel(),
            inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,  # it may not be closed, and weighs nothing anyway
        )
    # shapes of the bodies, without mass or contact, so that the dynamics stay as described
    for geom in geoms:
        form: dict[str, Any] = {"pos": geom.pos, "quat": geom.rotation}
        if geom.end is not None:
            form = {"size": [geom.size[0], 0, 0], "fromto": [*geom.pos, *geom.end]}
        elif geom.mesh is not None:
            form["meshname"] = meshes[geom.mesh]
        else:
            form["size"] = [*geom.size, 0, 0][:3]
        spec.body(geom.body).add_geom(
            type=GEOM_TYPES[geom.type], rgba=geom.colour, contype=0, conaffinity=0, mass=0.0, group=1, **form
        )
    # surroundings: floor, sky and light
    spec.worldbody.add_geom(
        name="floor",
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=[3, 3, 0.1],
        pos=[0, 0, -0.2 if robot.tool is None else 0],
        rgba=[0.6, 0.62, 0.64, 1],
        contype=0,
        conaffinity=0,
    )
    spec.add_texture(
        name="sky",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=[0.95, 0.96, 0.97],
        rgb2=[0.75, 0.8, 0.85],
        width=32,
        height=192,
    )
    spec.worldbody.add_light(pos=[1, -2, 4], dir=[-0.2, 0.4, -1], type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL)
    spec.visual.headlight.ambient = [0.35, 0.35, 0.35]
    spec.visual.headlight.diffuse = [0.4, 0.4, 0.4]
    spec.visual.map.znear = 0.01
