"""MJCF: read by MuJoCo as it stands, but for pictures on surfaces and shapes that are only looks."""

from pathlib import Path

import mujoco
import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.robot.arm_file.mesh_files import weighs
from ffgym.robot.arm_file.source import Source

_SMALL = 0.01
"""Radius [m] of the weightless sphere that stands for a shape that was left out; any would do."""


def read_mjcf(path: Path, *, looks: bool) -> Source:
    """Read an MJCF file, with what it includes.

    Raises:
        FFGymError: if a joint's limits are the wrong way round, which MuJoCo takes for no limits.
    """
    spec = mujoco.MjSpec.from_file(str(path))
    for joint in spec.joints:
        if joint.range[0] > joint.range[1]:
            raise FFGymError(f"Joint {joint.name!r}: range {joint.range.tolist()} must be lower before upper limit.")
    _drop_textures(spec)
    if not looks:
        _drop_shapes(spec)
    return Source(spec=spec)


def _drop_textures(spec: mujoco.MjSpec) -> None:
    for material in spec.materials:
        material.textures = [""] * len(material.textures)
    for texture in list(spec.textures):
        spec.delete(texture)


def _drop_shapes(spec: mujoco.MjSpec) -> None:
    """Put weightless spheres for all geoms whose mass does not count, and drop the meshes that nothing needs then.

    Spheres, and not nothing, because sensors, contact pairs and tendons may speak of the geoms.
    """
    for geom in spec.geoms:
        if weighs(spec, geom):
            continue
        geom.type, geom.size = mujoco.mjtGeom.mjGEOM_SPHERE, np.array([_SMALL, 0.0, 0.0])
        geom.meshname, geom.mass, geom.fromto = "", 0.0, np.full(6, np.nan)
    used = {geom.meshname for geom in spec.geoms}
    for mesh in list(spec.meshes):
        if mesh.name not in used:
            spec.delete(mesh)
