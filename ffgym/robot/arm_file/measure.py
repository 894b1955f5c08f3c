"""The numbers of a chain, read from MuJoCo's own kinematics with all joints at zero, as entries of a description."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from ffgym.core.errors import FFGymError, check_shape
from ffgym.core.types import Array
from ffgym.robot.arm_file.arm_file import ArmFile, JointHints, Kind, NamedFrame, Source
from ffgym.robot.arm_file.chain import BASE, TYPES, Chain
from ffgym.robot.reading.quantity import Quantity, si_units
from ffgym.robot.reading.rules import RULES

_PLACES = ("xanchor", "xaxis", "xpos", "xmat", "xipos", "ximat", "geom_xpos", "geom_xmat", "site_xpos", "site_xmat")
"""Results of the kinematics, in MuJoCo's words."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ZeroPose:
    """Model with its joints at zero, and the origins of the links of a chain then."""

    model: mujoco.MjModel
    data: mujoco.MjData
    chain: Chain
    origins: Array
    """Origin of each link in the world [m], shape (N, 3): a point on the axis of its joint."""

    def origin(self, owner: int) -> Array:
        """Origin of the frame of a link, or of the base, in the world [m], shape (3,)."""
        return np.zeros(3) if owner == BASE else self.origins[owner]


def pose_at_zero(model: mujoco.MjModel, chain: Chain) -> ZeroPose:
    """Put hinges and sliding joints at zero, whatever their `ref`; all others stay where the file draws them."""
    data = mujoco.MjData(model)
    data.qpos[[model.jnt_qposadr[j] for j in range(model.njnt) if model.jnt_type[j] in TYPES]] = 0.0
    mujoco.mj_kinematics(model, data)
    for name in _PLACES:
        if not np.all(np.isfinite(getattr(data, name))):
            raise FFGymError("A position, angle, axis or reference in it is not a finite number.")
    origins = data.xanchor[list(chain.joints)].copy()
    return ZeroPose(model=model, data=data, chain=chain, origins=origins)


def masses(pose: ZeroPose) -> dict[str, Array]:
    """Compute mass, centre of mass and inertia of the base and of each link with all that is welded to it."""
    base_mass, base_com, _ = _fuse(pose, BASE)
    links = [_fuse(pose, k) for k in range(len(pose.chain.joints))]
    for (mass, _, _), joint in zip(links, pose.chain.names, strict=True):
        if not mass > 0:
            raise FFGymError(
                f"The link behind joint {joint!r} weighs {mass} kg; a link that moves must weigh something."
            )
    mass, com, inertia = (np.array(column) for column in zip(*links, strict=True))
    of_links = {"links.mass": mass, "links.com": com, "links.inertia": inertia}
    return {"base.mass": base_mass, "base.com": base_com, **of_links}


def find_frames(pose: ZeroPose) -> dict[str, NamedFrame]:
    """Find bodies and sites of the last link, in its frame; a site wins over a body of its name."""
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


def _fuse(pose: ZeroPose, owner: int) -> tuple[Array, Array, Array]:
    """Fuse all bodies of an owner: mass, centre of mass and inertia about it (xx, yy, zz, xy, xz, yz)."""
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
    pose: ZeroPose, hints: Sequence[JointHints], file: str, kind: Kind, *, has_masses: bool
) -> dict[str, Quantity]:
    """Measure entries by path; `file` is their source, and without masses those of the links are left out."""
    model, chosen = pose.model, list(pose.chain.joints)
    sourced = ("sourced",)
    with np.errstate(over="ignore", invalid="ignore"):  # numbers that overflow are refused below
        axis = pose.data.xaxis[chosen]
        values = {
            "kinematics.position": np.diff(pose.origins, axis=0, prepend=np.zeros((1, 3))),
            "kinematics.axis": axis / np.linalg.norm(axis, axis=1, keepdims=True),
            **(masses(pose) if has_masses else {}),
        }
    rows: list[_Row] = [(path, value, sourced, file) for path, value in values.items()]
    if not has_masses:
        source = f"{file} has no masses; a base that stands still needs none"
        rows += [("base.mass", np.zeros(()), ("chosen",), source), ("base.com", np.zeros(3), ("chosen",), source)]
    said = (("chosen",), f"{file} says none; URDF has z upwards") if kind == "urdf" else (sourced, file)
    rows.append(("simulation.gravity", model.opt.gravity, *said))
    # joint limits; none at all if a sliding joint has none, as nothing says how far it could go
    limited = model.jnt_limited[chosen].astype(bool)
    if np.all(limited | (np.array(pose.chain.types) == "hinge")):
        limits = np.where(limited[:, None], model.jnt_range[chosen], UNLIMITED * np.array([-1.0, 1.0]))
        origin = tuple("sourced" if known else "chosen" for known in limited)
        source = file if np.all(limited) else f"{file}; one turn to both sides where it gives no limits"
        rows.append(("kinematics.range", limits, origin, source))
    if all(hint.speed is not None for hint in hints):
        rows.append(("kinematics.max_speed", np.array([hint.speed for hint in hints]), sourced, file))
    return _quantities(rows, pose.chain.types)


def flange_at(arm: ArmFile, frame: str) -> dict[str, Quantity]:
    """Return entries that put tool0, and the TCP as long as nothing else is said of it, at a named frame of the file.

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


def _quantities(rows: Sequence[_Row], types: tuple[str, ...]) -> dict[str, Quantity]:
    """Return entries of a description, checked to be finite, for joints of these types."""
    found = {}
    for path, value, origin, source in rows:
        rule = RULES[path]
        array = check_shape(path, value, np.shape(value)).copy()
        array.flags.writeable = False
        unit = ", ".join(si_units(rule, rule.side, types))
        found[path] = Quantity(value=array, unit=unit, side=rule.side, origin=origin, source=source)
    return found


_ON_JOINTS = (mujoco.mjtTrn.mjTRN_JOINT.value, mujoco.mjtTrn.mjTRN_JOINTINPARENT.value)
"""Transmissions of actuators that act on one joint alone."""


def joint_hints(model: mujoco.MjModel, chain: Chain, source: Source) -> tuple[JointHints, ...]:
    """Read hints about the drive of each joint of the chain."""

    def positive(value: float) -> float | None:
        return float(value) if value > 0 else None

    found = []
    for joint, name in zip(chain.joints, chain.names, strict=True):
        # actuators that act on this joint, with their gears
        dof = int(model.jnt_dofadr[joint])
        acting = np.flatnonzero(np.isin(model.actuator_trntype, _ON_JOINTS) & (model.actuator_trnid[:, 0] == joint))
        gears = model.actuator_gear[acting, 0].tolist()
        if not np.isfinite(gears).all():
            raise FFGymError(f"The gear of an actuator of joint {name!r} is {gears}, must be finite.")
        # largest torque: the joint's own limit, else what its actuators give at their force limits
        effort = 0.0
        if model.jnt_actfrclimited[joint]:
            effort = np.abs(model.jnt_actfrcrange[joint]).max()
        elif np.all(model.actuator_forcelimited[acting]):
            most = np.abs(model.actuator_forcerange[acting]).max(axis=1)
            effort = sum(abs(gear) * force for gear, force in zip(gears, most, strict=True))
        # rotor inertia, reflected through the square of the gear
        rotors = sum(gear**2 * x for gear, x in zip(gears, model.actuator_armature[acting], strict=True))
        # gains, seen from the joint, of servos with force = gain ctrl - K_p position - K_v velocity
        affine = model.actuator_biastype[acting] == mujoco.mjtBias.mjBIAS_AFFINE.value
        bias = model.actuator_biasprm[acting]
        kp, kv = (sum(-(g**2) * b[i] for g, b, own in zip(gears, bias, affine, strict=True) if own) for i in (1, 2))
        # the gear of the only actuator; 1, which MuJoCo sets where nothing is said, is none
        gear_ratio = gears[0] if len(gears) == 1 and gears[0] not in (0.0, 1.0) else None
        hints = JointHints(
            effort=positive(effort),
            speed=source.speeds.get(name),
            damping=positive(model.dof_damping[dof]),
            friction=positive(model.dof_frictionloss[dof]),
            armature=positive(model.dof_armature[dof] + rotors),
            gear_ratio=source.gear_ratios.get(name, gear_ratio),
            position_gain=positive(kp),
            velocity_gain=positive(kv),
        )
        found.append(hints)
    return tuple(found)


def left_out(model: mujoco.MjModel, chain: Chain) -> tuple[str, ...]:
    """Name each kind of force on the arm that is not taken over; a description has its own forms of them."""
    joints, moved = list(chain.joints), chain.owner >= 0
    springs = np.any(model.jnt_stiffness[joints]) or np.any(model.jnt_stiffnesspoly[joints])
    tendons = np.any(model.tendon_stiffness) or np.any(model.tendon_damping) or np.any(model.tendon_frictionloss)
    medium = model.opt.density > 0 or model.opt.viscosity > 0
    found = {
        "springs in its joints": springs,
        "springs, damping or friction of its tendons (counterbalances are entries of [springs])": tendons,
        "compensated gravity (gravcomp)": np.any(model.body_gravcomp[moved]),
        "forces of the air or water around it": medium,
    }
    return tuple(f"{what} are left out" for what, there in found.items() if there)
