"""The numbers of a chain, read from MuJoCo's own kinematics with all joints at zero, as entries of a description."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from ffgym.core.errors import FFGymError, check_shape
from ffgym.core.types import Array
from ffgym.robot.arm_file.arm_file import ArmFile, JointHints, Kind, NamedFrame
from ffgym.robot.arm_file.chain import BASE, TYPES, Chain
from ffgym.robot.reading.quantity import JointFrame, Quantity, si_units
from ffgym.robot.reading.rules import RULES

_PLACES = ("xanchor", "xaxis", "xpos", "xmat", "xipos", "ximat", "geom_xpos", "geom_xmat", "site_xpos", "site_xmat")
"""What kinematics compute, in MuJoCo's words."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Pose:
    """A model with its joints at zero, and where the links of a chain have their origins then."""

    model: mujoco.MjModel
    data: mujoco.MjData
    chain: Chain
    origins: Array
    """Origin of each link in the world [m], shape (N, 3): a point on the axis of its joint."""

    def origin(self, owner: int) -> Array:
        """Origin of the frame of a link, or of the base, in the world [m], shape (3,)."""
        return np.zeros(3) if owner == BASE else self.origins[owner]


def pose_at_zero(model: mujoco.MjModel, chain: Chain) -> Pose:
    """Put hinges and sliding joints at zero, whatever their `ref`; all others stay where the file draws them.

    Raises:
        FFGymError: if something is nowhere.
    """
    data = mujoco.MjData(model)
    for j in range(model.njnt):
        if model.jnt_type[j] in TYPES:
            data.qpos[model.jnt_qposadr[j]] = 0.0
    mujoco.mj_kinematics(model, data)
    for name in _PLACES:
        if not np.all(np.isfinite(getattr(data, name))):
            raise FFGymError("A position, angle, axis or reference in it is not a finite number.")
    origins = data.xanchor[list(chain.joints)].copy()
    return Pose(model=model, data=data, chain=chain, origins=origins)


def geometry(pose: Pose) -> dict[str, Array]:
    """`kinematics.position` [m], shape (N, 3), and `kinematics.axis`, shape (N, 3)."""
    axis = pose.data.xaxis[list(pose.chain.joints)]
    steps = np.diff(pose.origins, axis=0, prepend=np.zeros((1, 3)))
    return {"kinematics.position": steps, "kinematics.axis": axis / np.linalg.norm(axis, axis=1, keepdims=True)}


def masses(pose: Pose) -> dict[str, Array]:
    """Mass, centre of mass and inertia of the base and of each link with all that is welded to it.

    Raises:
        FFGymError: if a link weighs nothing.
    """
    base_mass, base_com, _ = _fused(pose, BASE)
    links = [_fused(pose, k) for k in range(len(pose.chain.joints))]
    found = {"base.mass": base_mass, "base.com": base_com}
    for name, column in zip(("mass", "com", "inertia"), zip(*links, strict=True), strict=True):
        found[f"links.{name}"] = np.array(column)
    for mass, joint in zip(found["links.mass"], pose.chain.names, strict=True):
        if not mass > 0:
            raise FFGymError(
                f"The link behind joint {joint!r} weighs {mass} kg; a link that moves must weigh something."
            )
    return found


def named_frames(pose: Pose) -> dict[str, NamedFrame]:
    """Bodies and sites of the last link, in its frame; a site wins over a body of its name."""
    model, data = pose.model, pose.data
    last = len(pose.chain.joints) - 1
    frames = {}
    for count, owner_of, access, points, turns in (
        (model.nbody, np.arange(model.nbody), model.body, data.xpos, data.xmat),
        (model.nsite, model.site_bodyid, model.site, data.site_xpos, data.site_xmat),
    ):
        for i in range(count):
            name = access(i).name
            if name and pose.chain.owner[owner_of[i]] == last:
                position = points[i] - pose.origin(last)
                frames[name] = NamedFrame(position=position, rotation=turns[i].reshape(3, 3).copy())
    return frames


def _fused(pose: Pose, owner: int) -> tuple[Array, Array, Array]:
    """Mass, centre of mass and inertia about it (xx, yy, zz, xy, xz, yz) of all bodies of an owner, as one."""
    model, data = pose.model, pose.data
    bodies = np.flatnonzero(pose.chain.owner == owner)
    mass = model.body_mass[bodies]
    total = mass.sum()
    if total == 0:
        return total, np.zeros(3), np.zeros(6)
    com = mass @ data.xipos[bodies] / total
    tensor = np.zeros((3, 3))
    for body in bodies:
        turn, offset = data.ximat[body].reshape(3, 3), data.xipos[body] - com
        tensor += turn @ np.diag(model.body_inertia[body]) @ turn.T
        tensor += model.body_mass[body] * (offset @ offset * np.eye(3) - np.outer(offset, offset))
    inertia = tensor[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
    return total, com - pose.origin(owner), inertia


UNLIMITED = 2 * np.pi
"""Range of a hinge without limits, to both sides [rad]: one turn, what cables along an arm usually bear."""

_Row = tuple[str, Array, tuple[str, ...], str]
"""Path of an entry, its value in SI units, origin and source."""


def quantities_of(
    pose: Pose, hints: Sequence[JointHints], file: str, kind: Kind, *, has_masses: bool
) -> dict[str, Quantity]:
    """Entries by path; `file` is their source, and without masses those of the links are left out.

    Raises:
        FFGymError: if a link weighs nothing, or a number is not finite.
    """
    with np.errstate(over="ignore", invalid="ignore"):  # numbers that overflow are refused below
        values = geometry(pose) | (masses(pose) if has_masses else {})
    rows: list[_Row] = [(path, value, ("sourced",), file) for path, value in values.items()]
    if not has_masses:
        source = f"{file} has no masses; a base that stands still needs none"
        rows += [("base.mass", np.zeros(()), ("chosen",), source), ("base.com", np.zeros(3), ("chosen",), source)]
    said = (("chosen",), f"{file} says none; URDF has z upwards") if kind == "urdf" else (("sourced",), file)
    rows.append(("simulation.gravity", pose.model.opt.gravity, *said))
    rows += _range(pose, file)
    if all(hint.speed is not None for hint in hints):
        rows.append(("kinematics.max_speed", np.array([hint.speed for hint in hints]), ("sourced",), file))
    return _quantities(rows, pose.chain.types)


def flange_at(arm: ArmFile, frame: str) -> dict[str, Quantity]:
    """Entries that put tool0, and the TCP as long as nothing else is said of it, at a named frame of the file.

    Raises:
        FFGymError: if the last link has no such frame.
    """
    place, source = arm.frame(frame), f"{Path(arm.path).name}, frame {frame}"
    rows: list[_Row] = [
        ("flange.position", place.position, ("sourced",), source),
        ("flange.rotation", place.rotation, ("sourced",), source),
        ("tool.tcp", np.zeros(3), ("chosen",), f"origin of frame {frame}"),
    ]
    return _quantities(rows, arm.types)


def _range(pose: Pose, file: str) -> list[_Row]:
    """Joint limits; none at all if a sliding joint has none, as nothing says how far it could go."""
    chosen = list(pose.chain.joints)
    limited = pose.model.jnt_limited[chosen].astype(bool)
    hinges = np.array([kind == "hinge" for kind in pose.chain.types])
    if not np.all(limited | hinges):
        return []
    limits = np.where(limited[:, None], pose.model.jnt_range[chosen], UNLIMITED * np.array([-1.0, 1.0]))
    origin = tuple("sourced" if known else "chosen" for known in limited)
    source = file if np.all(limited) else f"{file}; one turn to both sides where it gives no limits"
    return [("kinematics.range", limits, origin, source)]


def _quantities(rows: Sequence[_Row], types: tuple[str, ...]) -> dict[str, Quantity]:
    """Entries of a description, checked to be finite, for joints of these types."""
    found = {}
    for path, value, origin, source in rows:
        rule = RULES[path]
        array = check_shape(path, value, np.shape(value)).copy()
        array.flags.writeable = False
        unit = ", ".join(si_units(rule, rule.side, JointFrame(types=types)))
        found[path] = Quantity(value=array, unit=unit, side=rule.side, origin=origin, source=source)
    return found
