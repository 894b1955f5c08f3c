r"""A base that gives way under the arm: how it tilts along measured motions, and what that asks of the joints.

.. math::
    \begin{pmatrix} M_{bb} & M_{bj} \\ M_{jb} & M_{jj} \end{pmatrix}
    \begin{pmatrix} \ddot\varphi \\ \ddot q + \ddot\delta \end{pmatrix} + h(\varphi, q, \dot q) =
    \begin{pmatrix} -\varphi / c - t_d \dot\varphi / c \\ -K \delta - d \dot\delta \end{pmatrix}

It is the replay's balance with three more joints, whose motors stand. What they ask of the joints of the arm is then
a torque like any other, which springs and motors bear.
"""

from dataclasses import dataclass

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.log import Log
from ffgym.diagnosis.replay.link_terms import LinkTerms, link_terms
from ffgym.diagnosis.replay.springs import Springs
from ffgym.effects.transmission.base_flexibility import BaseFlexibility
from ffgym.robot import RigidArm, RobotDescription
from ffgym.robot.dynamics.arm import RIGID
from ffgym.simulation.plant import Machine

_AXES = 3

_LEAN = 1e-3
"""By which the base is turned to see what that asks of joints [rad]; chosen: little, and far from rounding."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Tilt:
    """Of a base, along M motions of T samples."""

    angle: Array
    """About the axes of the world [rad], shape (T, M, 3)."""
    torque: Array
    """What it asks of the joints of the arm, link side [N m], shape (T, M, N)."""

    def moved(self, points: Array, every: int = 1) -> Array:
        """Where it takes points (T', M, 3) [m] of the arm; `every` so many samples."""
        return points + np.cross(self.angle[::every], points)


@dataclass(frozen=True, kw_only=True, eq=False)
class BaseTerms:
    """What links ask for on a base that may turn about three axes; joints of the base come first."""

    upright: LinkTerms
    """(T, M, 3 + N)."""
    lean: Array
    """What the joints of the arm take more for each radian that the base leans [N m/rad], shape (T, M, N, 3)."""


def base_of(machine: Machine) -> BaseFlexibility | None:
    """The flexibility of the machine's base, if it has one."""
    for effect in machine.effects:
        if isinstance(effect, BaseFlexibility) and not effect.is_null:
            return effect
    return None


def base_terms(log: Log, robot: RobotDescription) -> BaseTerms:
    """Terms along measured motions; poses are those of the motors: what joints bend hardly loads a base otherwise."""
    arm = _arm_on_base(robot)
    q, dq = _beside_base(log.q), _beside_base(log.dq)
    upright, lean = link_terms(arm, q, dq, log.dt), np.empty((*log.q.shape, _AXES))
    for axis in range(_AXES):
        leaning = q.copy()
        leaning[..., axis] = _LEAN
        lean[..., axis] = (link_terms(arm, leaning, dq, log.dt).bias - upright.bias)[..., _AXES:] / _LEAN
    return BaseTerms(upright=upright, lean=lean)


def tilt_of(log: Log, robot: RobotDescription, base: BaseFlexibility, terms: BaseTerms) -> Tilt:
    """How a base tilts under a robot whose motors move as measured."""
    stiffness, damping = _springs(base)
    springs = Springs(
        mass=terms.upright.mass,
        stiffness=np.concatenate([stiffness, robot.drive.joint_stiffness]),
        damping=np.concatenate([damping, robot.drive.joint_damping]),
        dt=log.dt,
    )
    bent = springs.bent_by(-terms.upright.torque(_beside_base(log.ddq))[..., None])
    shaken = np.matmul(terms.upright.mass[..., _AXES:, :_AXES], bent.acceleration[..., :_AXES, :])
    leant = np.matmul(terms.lean, bent.angle[..., :_AXES, :])
    return Tilt(angle=bent.angle[..., :_AXES, 0], torque=(shaken + leant)[..., 0])


def _springs(base: BaseFlexibility) -> tuple[Array, Array]:
    """Stiffness [N m/rad] and damping [N m s/rad] about each axis; inf and 0 where nothing gives way."""
    gives_way = base.compliance > 0
    stiffness = np.divide(1.0, base.compliance, out=np.full(_AXES, np.inf), where=gives_way)
    return stiffness, np.where(gives_way, float(base.relaxation) * np.where(gives_way, stiffness, 0.0), 0.0)


def _arm_on_base(robot: RobotDescription) -> RigidArm:
    """The links on a base that turns about all three axes, whatever holds it."""
    anyhow = BaseFlexibility(compliance=np.ones(_AXES), relaxation=np.array(0.0))
    return RigidArm(robot, Machine(robot=robot, effects=(anyhow,)).spec(RIGID).compile())


def _beside_base(values: Array) -> Array:
    """Values (T, M, N) of joints behind those of a base that stands."""
    return np.concatenate([np.zeros((*values.shape[:2], _AXES)), values], axis=2)
