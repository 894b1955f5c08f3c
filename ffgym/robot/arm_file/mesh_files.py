"""Where meshes are, and what helps where they are not."""

from pathlib import Path

import mujoco
import numpy as np

from ffgym.core.errors import FFGymError

READABLE = (".stl", ".obj", ".msh")
"""Formats that MuJoCo reads."""

WAY_OUT = 'or leave the looks out: --no-looks of ffgym robot new, looks = "none" in [robot], looks=False in read_arm'
"""What helps against any trouble with a mesh."""


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
