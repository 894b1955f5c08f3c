"""What a compiled model says of an arm beside its numbers: hints about drives, looks, and what is left out."""

from collections.abc import Sequence

import mujoco
import numpy as np

from ffgym.core.types import Array, IntArray
from ffgym.robot.arm_file.arm_file import JointHints, Source
from ffgym.robot.arm_file.chain import BASE, Chain
from ffgym.robot.arm_file.measure import Pose
from ffgym.robot.parts import Geom, Mesh


def joint_hints(model: mujoco.MjModel, chain: Chain, source: Source) -> tuple[JointHints, ...]:
    """Hints for each joint of the chain."""
    return tuple(_hints(model, j, name, source) for j, name in zip(chain.joints, chain.names, strict=True))


def _hints(model: mujoco.MjModel, joint: int, name: str, source: Source) -> JointHints:
    dof = int(model.jnt_dofadr[joint])
    actuators = _actuators(model, joint)
    servo = _servo_gains(model, actuators)
    return JointHints(
        effort=_effort(model, joint, actuators),
        speed=source.speeds.get(name),
        damping=_positive(model.dof_damping[dof]),
        friction=_positive(model.dof_frictionloss[dof]),
        armature=_positive(
            model.dof_armature[dof] + sum(_gear(model, a) ** 2 * model.actuator_armature[a] for a in actuators)
        ),
        gear_ratio=source.gear_ratios.get(name, _gear_ratio(model, actuators)),
        position_gain=_positive(servo[0]),
        velocity_gain=_positive(servo[1]),
    )


def _actuators(model: mujoco.MjModel, joint: int) -> IntArray:
    """Actuators that act on a joint and on nothing else."""
    kinds = (mujoco.mjtTrn.mjTRN_JOINT.value, mujoco.mjtTrn.mjTRN_JOINTINPARENT.value)
    return np.flatnonzero(np.isin(model.actuator_trntype, kinds) & (model.actuator_trnid[:, 0] == joint))


def _gear(model: mujoco.MjModel, actuator: int) -> float:
    return float(model.actuator_gear[actuator, 0])


def _gear_ratio(model: mujoco.MjModel, actuators: IntArray) -> float | None:
    """The gear of the only actuator; 1, which MuJoCo sets where nothing is said, is none."""
    ratio = _gear(model, actuators[0]) if len(actuators) == 1 else 1.0
    return None if ratio in (0.0, 1.0) else ratio


def _effort(model: mujoco.MjModel, joint: int, actuators: IntArray) -> float | None:
    """Largest torque of a joint: its own limit, else what its actuators give at their force limits."""
    if model.jnt_actfrclimited[joint]:
        return _positive(np.abs(model.jnt_actfrcrange[joint]).max())
    if not len(actuators) or not np.all(model.actuator_forcelimited[actuators]):
        return None
    return _positive(sum(abs(_gear(model, a)) * np.abs(model.actuator_forcerange[a]).max() for a in actuators))


def _servo_gains(model: mujoco.MjModel, actuators: IntArray) -> tuple[float, float]:
    """K_p and K_v, seen from the joint, of servos with force = gain ctrl - K_p position - K_v velocity."""
    affine = [a for a in actuators if model.actuator_biastype[a] == mujoco.mjtBias.mjBIAS_AFFINE.value]
    kp, kv = (sum(-(_gear(model, a) ** 2) * model.actuator_biasprm[a, i] for a in affine) for i in (1, 2))
    return float(kp), float(kv)


def _positive(value: float) -> float | None:
    return float(value) if value > 0 else None


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


def left_out(model: mujoco.MjModel, chain: Chain) -> tuple[str, ...]:
    """One phrase for each kind of force on the arm that is not taken over; a description has its own forms of them."""
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
