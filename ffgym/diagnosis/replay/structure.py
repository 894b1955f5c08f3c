r"""Structure that gives way along measured motions: a base that tilts, links that bend.

.. math::
    \begin{pmatrix} M_{bb} & M_{bj} \\ M_{jb} & M_{jj} \end{pmatrix}
    \begin{pmatrix} \ddot\varphi \\ \ddot q + \ddot\delta \end{pmatrix} + h(\varphi, q, \dot q) =
    \begin{pmatrix} -\varphi / c - t_d \dot\varphi / c \\ -K \delta - d \dot\delta \end{pmatrix}

It is the replay's balance with more joints, which have no motors. What they ask of the joints of the arm is then a
torque like any other, which springs and motors bear.
"""

from dataclasses import dataclass, replace

import mujoco
import numpy as np

from ffgym.core.types import Array, IntArray
from ffgym.diagnosis.log import Log
from ffgym.diagnosis.replay.links import LinkTerms, link_terms
from ffgym.diagnosis.replay.recursions import along, places_of
from ffgym.diagnosis.replay.springs import Springs
from ffgym.diagnosis.settings import settings
from ffgym.effects import ModelEffect
from ffgym.effects.transmission.base_flexibility import BaseFlexibility
from ffgym.effects.transmission.link_flexibility import LinkFlexibility
from ffgym.robot import RigidArm, RobotDescription
from ffgym.robot.dynamics.arm import RIGID
from ffgym.robot.model.names import motor_joint
from ffgym.simulation.plant import Machine

_LEAN = 1e-3
"""Angle by which a joint of the structure is turned for differences of torques [rad]; chosen: little, and far from
rounding."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Sway:
    """Motion of a structure of E joints without motors, along M motions of T samples."""

    angle: Array
    """[rad], shape (T, M, E)."""
    torque: Array
    """Torque that the motion of the structure takes of the joints of the arm, link side [N m], shape (T, M, N)."""
    tool: Array | None
    """Displacement of the tool by it [m], (T, M, 3); None for a robot without tool."""

    def move(self, points: Array, every: int = 1) -> Array:
        """Move positions of the tool (T', M, 3) [m] with the structure; `every` so many samples."""
        return points if self.tool is None else points + self.tool[::every]


@dataclass(frozen=True, kw_only=True, eq=False)
class StructureTerms:
    """Terms of the links on a structure that may give way; E joints without motors among those of the arm."""

    names: tuple[str, ...]
    """Joints of the structure in the MuJoCo model."""
    own: IntArray
    """Places of the arm's joints among all, (N,)."""
    extra: IntArray
    """Places of the structure's joints, (E,)."""
    upright: LinkTerms
    """(T, M, E + N)."""
    lean: Array
    """Torque that the joints of the arm take more per angle of the structure [N m/rad], shape (T, M, N, E)."""
    tool: Array | None
    """Displacement of the tool per angle of the structure [m/rad], (T, M, 3, E); None for a robot without tool."""

    def among_all(self, values: Array) -> Array:
        """Values (T, M, N) of the arm's joints among those of a structure that stands, (T, M, E + N)."""
        found = np.zeros((*values.shape[:2], len(self.own) + len(self.extra)))
        found[..., self.own] = values
        return found


StructureKey = tuple[bool, tuple[int, ...]]
"""Parts that give way: the base, and links by the places of their joints."""


def find_structure(machine: Machine) -> StructureKey | None:
    """Find what gives way of a machine; None if nothing does."""
    effects = [effect for effect in machine.effects if isinstance(effect, ModelEffect) and not effect.is_null]
    links = [np.flatnonzero(effect.compliance) for effect in effects if isinstance(effect, LinkFlexibility)]
    has_base = any(isinstance(effect, BaseFlexibility) for effect in effects)
    bent = sorted({int(j) for joints in links for j in joints})
    return (has_base, tuple(bent)) if has_base or bent else None


def structure_terms(log: Log, robot: RobotDescription, parts: StructureKey, bent: Array | None) -> StructureTerms:
    """Terms along measured motions, for any compliance of these parts.

    Poses are those of the motors: what joints bend hardly loads a structure otherwise. The tool is where joints that
    are `bent` (T, M, N) [rad] put it; None is not at all.
    """
    # the links on a base that turns about all three axes, and links that bend, whatever holds them
    has_base, joints = parts
    yields = [BaseFlexibility(compliance=np.ones(3), relaxation=np.array(0.0))] if has_base else []
    soft = np.zeros(robot.n_joints)
    soft[list(joints)] = 1.0
    links = [LinkFlexibility(compliance=soft, relaxation=np.array(0.0))] if joints else []
    model = Machine(robot=robot, effects=(*yields, *links)).spec(RIGID).compile()
    arm, names = RigidArm(robot, model), [model.joint(i).name for i in range(model.njnt)]
    own = np.array([names.index(motor_joint(joint)) for joint in robot.joints])
    extra = np.setdiff1d(np.arange(model.njnt), own)
    found = StructureTerms(
        names=tuple(names[i] for i in extra),
        own=own,
        extra=extra,
        upright=LinkTerms(mass=np.zeros(0), bias=np.zeros(0)),
        lean=np.zeros((*log.q.shape, len(extra))),
        tool=None,
    )
    # torque along the motion, and what it changes where each joint of the structure is turned a little
    q, dq, ddq = (found.among_all(values) for values in (log.q, log.dq, log.ddq))
    upright = link_terms(arm, q, dq, log.dt)
    stands = upright.torque(ddq)
    for k, place in enumerate(extra):
        q[..., place] = _LEAN
        found.lean[..., k] = (link_terms(arm, q, dq, log.dt).torque(ddq) - stands)[..., own] / _LEAN
        q[..., place] = 0.0
    tool = None
    if robot.tool is not None:
        q = q if bent is None else q + found.among_all(bent)
        tool = _displacements(arm, q, log.dt, extra)
    return replace(found, upright=upright, tool=tool)


def _displacements(arm: RigidArm, q: Array, dt: float, joints: IntArray) -> Array:
    """Displacement of the tool per angle of some joints [m/rad] at positions q, (T, M, 3, E)."""
    places = places_of(len(q), max(1, round(settings().replay.link_period / dt)))
    there = q[places]
    jacobian = arm.jacobian(there.reshape(-1, q.shape[-1]))[:, :3, joints]
    return along(places, jacobian.reshape(*there.shape[:2], 3, len(joints)))


def sway_of(log: Log, machine: Machine, terms: StructureTerms) -> Sway:
    """Compute the motion of the structure of a machine whose motors move as measured."""
    # stiffness [N m/rad] and damping [N m s/rad] of its joints; inf and 0 where nothing gives way
    drive, extra = machine.physical.drive, terms.extra
    stiffness, damping = np.full(len(extra) + len(terms.own), np.inf), np.zeros(len(extra) + len(terms.own))
    stiffness[terms.own], damping[terms.own] = drive.joint_stiffness, drive.joint_damping
    stiffness[extra], damping[extra] = _springs_of(machine, terms.names)
    springs = Springs(mass=terms.upright.mass, stiffness=stiffness, damping=damping, dt=log.dt)
    bent = springs.bent_by(-terms.upright.torque(terms.among_all(log.ddq))[..., None])
    angle = bent.angle[..., extra, :]
    shaken = np.matmul(terms.upright.mass[..., terms.own[:, None], extra], bent.acceleration[..., extra, :])
    return Sway(
        angle=angle[..., 0],
        torque=(shaken + np.matmul(terms.lean, angle))[..., 0],
        tool=None if terms.tool is None else np.matmul(terms.tool, angle)[..., 0],
    )


def _springs_of(machine: Machine, names: tuple[str, ...]) -> tuple[Array, Array]:
    """Stiffness and damping of joints that effects add to the model, (E,) each; inf and 0 where they add none."""
    effects = tuple(effect for effect in machine.effects if isinstance(effect, ModelEffect))
    model = Machine(robot=machine.physical, effects=effects).spec(RIGID).compile()
    stiffness, damping = np.full(len(names), np.inf), np.zeros(len(names))
    for k, name in enumerate(names):
        joint = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, name)
        if joint >= 0:
            stiffness[k] = np.ravel(model.jnt_stiffness[joint])[0]
            damping[k] = np.ravel(model.dof_damping[model.jnt_dofadr[joint]])[0]
    return stiffness, damping
