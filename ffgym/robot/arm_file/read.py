"""Read an arm from MJCF or URDF: MuJoCo's parser and kinematics, then numbers in the frames of a description."""

import re
import warnings as python_warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import MappingProxyType

import mujoco
import numpy as np

from ffgym.core.errors import FFGymError, errors_at
from ffgym.core.files import read_bytes
from ffgym.robot.arm_file.arm_file import ArmFile, Kind, Source
from ffgym.robot.arm_file.chain import check_open, choose_chain
from ffgym.robot.arm_file.extent import check_extent, check_lengths
from ffgym.robot.arm_file.measure import find_frames, joint_hints, left_out, pose_at_zero, quantities_of
from ffgym.robot.arm_file.shapes import WAY_OUT, looks_of, weighs
from ffgym.robot.arm_file.urdf import read_urdf

_WAYS_OUT = (
    (
        "mass and inertia of moving bodies",
        "A link that moves must weigh something, itself or through what is welded to it: give it a mass and an "
        "inertia, or weld it to the link before it",
    ),
    ("inertia must", "No body has such an inertia; take it about the centre of mass, in kg m^2, from the CAD model"),
    ("ASCII file", f"Save the mesh as binary STL, {WAY_OUT}"),
    ("stl_decoder", f"Copy or make the mesh again, {WAY_OUT}"),
    ("obj_decoder", f"Copy or make the mesh again, {WAY_OUT}"),
    ("mesh", f"Repair the mesh, {WAY_OUT}"),
    ("vertices", f"Repair the mesh, {WAY_OUT}"),
    ("find decoder", "Give it a name that ends in .xml"),
    ("Error opening file", "Put the file there"),
)
"""Advice on foreseen messages; the first that fits is added."""


@contextmanager
def _engine_errors(*, line_numbers: bool) -> Iterator[list[str]]:
    """Raise what MuJoCo refuses as an FFGymError; yields the list that its warnings go to.

    Without this, MuJoCo prints its warnings and writes them to MUJOCO_LOG.TXT in the working directory. `line_numbers`
    says whether the lines it names are those of the user's file, and may be shown.
    """
    said: list[str] = []
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(said.append)
    try:
        with python_warnings.catch_warnings(record=True) as caught:
            python_warnings.simplefilter("always")
            yield said
        said += [_one_line(str(warning.message)) for warning in caught]
    except FFGymError:
        raise
    except (ValueError, mujoco.FatalError, mujoco.UnexpectedError) as error:
        message = str(error) if line_numbers else re.sub(r",? line \d+", "", str(error))
        text = re.sub(r"^((XML )?Error: )+", "", _one_line(message)).rstrip(".;:")
        ways = [f" {way}." for sign, way in _WAYS_OUT if sign in text]
        raise FFGymError(f"MuJoCo refuses it: {text}.{''.join(ways[:1])}") from error
    finally:
        mujoco.set_mju_user_warning(before)


def _compile(spec: mujoco.MjSpec) -> mujoco.MjModel:
    """Compile a model with all its bodies, also those that are welded, and with what is only looks."""
    spec.compiler.fusestatic = False
    spec.compiler.discardvisual = False
    spec.compiler.usethread = False  # so that warnings come from the thread that holds Python's lock
    try:
        model = spec.compile()
        model.names.decode("utf-8")
    except UnicodeDecodeError as error:
        raise FFGymError("Names in it are not UTF-8 text. Save the file as UTF-8.") from error
    except ValueError as error:
        missing = re.search(r"Error opening file '(.+)'", str(error))
        for mesh in spec.meshes:
            if missing is not None and Path(mesh.file).name == Path(missing[1]).name:
                # without looks it does not matter, unless the mass of a body needs it
                bodies = [g.parent.name for g in spec.geoms if g.meshname == mesh.name and weighs(spec, g)]
                inertial = f"or give body {bodies[0]!r} an <inertial>: its mass comes from this mesh" if bodies else ""
                place = Path(spec.modelfiledir) / missing[1]
                raise FFGymError(
                    f"The mesh {mesh.name!r} is missing; looked for {place}. Put it there, {inertial or WAY_OUT}."
                ) from error
        raise
    return model


def _one_line(message: str) -> str:
    return "; ".join(line.strip() for line in message.splitlines() if line.strip())


_SMALL = 0.01
"""Radius [m] of the weightless sphere that stands for a shape that was left out; any would do."""


def _read_mjcf(path: Path, *, looks: bool) -> Source:
    """Read an MJCF file, with what it includes."""
    check_extent(path)
    spec = mujoco.MjSpec.from_file(str(path))
    for joint in spec.joints:
        if joint.range[0] > joint.range[1]:
            raise FFGymError(f"Joint {joint.name!r}: range {joint.range.tolist()} must be lower before upper limit.")
    for material in spec.materials:
        material.textures = [""] * len(material.textures)
    for texture in list(spec.textures):
        spec.delete(texture)
    if not looks:
        _drop_shapes(spec)
    return Source(spec=spec)


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


def read_arm(path: str | Path, joints: Sequence[str] | None = None, *, looks: bool = True) -> ArmFile:
    """Read the serial arm in an MJCF or URDF file.

    Args:
        path: the file.
        joints: names of the joints that move, from the base outwards; all others are held at zero and their links
            become part of the link before them. None takes all joints of the file, which must be one chain.
        looks: whether to read shapes and meshes; without, missing meshes do not matter.

    Raises:
        FFGymError: if there is no such file, it is not MJCF or URDF, or what it describes is no serial arm of rigid
            links with hinges and sliding joints.
    """
    path = Path(path)
    if isinstance(joints, str):
        raise FFGymError(f"joints = {joints!r} must be a list of names, ['{joints}'].")
    with errors_at(str(path)):
        return _read(path, joints, looks)


def _read(path: Path, joints: Sequence[str] | None, looks: bool) -> ArmFile:
    data = read_bytes(path)
    # format by the outermost element of the file
    text = re.sub(r"<!--.*?-->|<\?.*?\?>|<![^>]*>", "", data.decode("latin-1"), flags=re.DOTALL)
    found = re.search(r"<([\w:.-]+)", text)
    kinds: dict[str, Kind] = {"mujoco": "mjcf", "robot": "urdf"}
    if found is None or found[1] not in kinds:
        what = "it is empty" if not data.strip() else f"it starts with <{found[1]}>" if found else "it is no XML"
        raise FFGymError(f"It must be MJCF (<mujoco> ...) or URDF (<robot> ...), but {what}.")
    kind = kinds[found[1]]
    mjcf = kind == "mjcf"
    # compile in the engine, which finds further errors and warns
    with _engine_errors(line_numbers=mjcf) as warnings:
        source = _read_mjcf(path, looks=looks) if mjcf else read_urdf(data, path.parent, joints, looks=looks)
        check_lengths(source.spec)
        model = _compile(source.spec)
    # measure the chain at zero angles
    chain = choose_chain(model, joints)
    check_open(model, chain)
    pose = pose_at_zero(model, chain)
    links = tuple(model.body(model.jnt_bodyid[j]).name or f"link{k + 1}" for k, j in enumerate(chain.joints))
    hints = joint_hints(model, chain, source)
    return ArmFile(
        path=str(path),
        kind=kind,
        joints=chain.names,
        links=links,
        types=chain.types,
        quantities=MappingProxyType(quantities_of(pose, hints, path.name, kind, has_masses=source.has_masses)),
        frames=MappingProxyType(find_frames(pose)),
        hints=hints,
        geoms=looks_of(pose, links) if looks else (),
        notes=(*source.notes, *left_out(model, chain), *warnings),
    )
