"""Read an arm from MJCF or URDF: MuJoCo's parser and kinematics, then numbers in the frames of a description."""

import re
from collections.abc import Sequence
from pathlib import Path
from types import MappingProxyType

from ffgym.core.errors import FFGymError
from ffgym.robot.arm_file.arm_file import ArmFile, Kind
from ffgym.robot.arm_file.chain import choose_chain
from ffgym.robot.arm_file.engine import compiled, engine_errors
from ffgym.robot.arm_file.hints import joint_hints
from ffgym.robot.arm_file.looks import looks_of
from ffgym.robot.arm_file.loops import check_open
from ffgym.robot.arm_file.measure import named_frames, pose_at_zero
from ffgym.robot.arm_file.mjcf import read_mjcf
from ffgym.robot.arm_file.notes import left_out
from ffgym.robot.arm_file.quantities import quantities_of
from ffgym.robot.arm_file.urdf import read_urdf


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
    try:
        return _read(path, joints, looks)
    except FFGymError as error:
        raise FFGymError(f"{path}: {error}") from error


def _read(path: Path, joints: Sequence[str] | None, looks: bool) -> ArmFile:
    try:
        data = path.read_bytes()
    except OSError as error:
        raise FFGymError(f"Cannot read it: {error.strerror}. It must be an MJCF or URDF file.") from error
    kind = _kind(data)
    mjcf = kind == "mjcf"
    with engine_errors(line_numbers=mjcf) as warnings:
        source = read_mjcf(path, looks=looks) if mjcf else read_urdf(data, path.parent, joints, looks=looks)
        model = compiled(source.spec)
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
        frames=MappingProxyType(named_frames(pose)),
        hints=hints,
        geoms=looks_of(pose, links) if looks else (),
        notes=(*source.notes, *left_out(model, chain), *warnings),
    )


def _kind(data: bytes) -> Kind:
    """Format by the outermost element of the file."""
    text = re.sub(r"<!--.*?-->|<\?.*?\?>|<![^>]*>", "", data.decode("latin-1"), flags=re.DOTALL)
    found = re.search(r"<([\w:.-]+)", text)
    kinds: dict[str, Kind] = {"mujoco": "mjcf", "robot": "urdf"}
    if found is None or found[1] not in kinds:
        what = "it is empty" if not data.strip() else f"it starts with <{found[1]}>" if found else "it is no XML"
        raise FFGymError(f"It must be MJCF (<mujoco> ...) or URDF (<robot> ...), but {what}.")
    return kinds[found[1]]
