r"""Parts of the motor torque that are linear in their parameters, and the motion that they are computed of.

Links behind elastic joints move as the torque that they take bends these,

.. math:: K \delta = -\tau(q, \dot q, \ddot q), \quad q_{link} = q + \delta

with positions q of rigid joints at the measured motor angles. Sag and windup are small against the motion, so that the
torque is taken at q, of the parameters that are known so far.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.types import Array
from ffgym.diagnosis.identification.rigid_body.bodies import (
    PARAMETERS,
    UNITS,
    bodies_of,
    body_torque,
    body_torque_columns,
    with_bodies,
)
from ffgym.robot import RigidArm, RobotDescription

_ABOVE_ZERO = 1e-3
"""Smallest share of its size that a parameter may have that a description must give above 0."""


@dataclass(frozen=True, kw_only=True, eq=False)
class JointMotion:
    """Motion of an arm and its motors at instants, T rows and N joints."""

    q: Array
    """Positions of the links, link side [rad or m], shape (T, N)."""
    dq: Array
    ddq: Array
    motor_dq: Array
    """Motor speed [rad/s], shape (T, N)."""
    motor_ddq: Array
    """Motor acceleration [rad/s^2], shape (T, N)."""


def rigid_motion(robot: RobotDescription, q: Array, dq: Array, ddq: Array) -> JointMotion:
    """Motion of an arm with rigid joints from joint positions, speeds and accelerations, shape (T, N)."""
    drive = robot.drive
    return JointMotion(q=q, dq=dq, ddq=ddq, motor_dq=drive.motor_angle(dq), motor_ddq=drive.motor_angle(ddq))


def elastic_motion(robot: RobotDescription, motion: JointMotion, bodies: Array, dt: float) -> JointMotion:
    """Let the joints of a rigid `motion`, sampled every `dt` [s], bend under `bodies` with parameters (10 B,)."""
    if robot.drive.is_rigid.all():
        return motion
    torque = body_torque(robot, bodies.reshape(-1, 10), motion.q, motion.dq, motion.ddq)
    torque += RigidArm(robot).spring_torque(motion.q)
    bend = -torque / robot.drive.joint_stiffness
    rate = np.gradient(bend, dt, axis=0)
    return replace(motion, q=motion.q + bend, dq=motion.dq + rate, ddq=motion.ddq + np.gradient(rate, dt, axis=0))


@dataclass(frozen=True, kw_only=True, eq=False)
class Term:
    """A part of the motor torque that is linear in K parameters."""

    name: str
    """For settings and files."""
    labels: Callable[[RobotDescription], tuple[str, ...]]
    """Name of each parameter, K of them."""
    units: Callable[[RobotDescription], tuple[str, ...]]
    described: Callable[[RobotDescription], Array]
    """What the description says of each parameter, 0 where it knows no such thing, shape (K,)."""
    columns: Callable[[RobotDescription, JointMotion], Iterator[Array]]
    """Motor torque of each parameter at 1, motor side [N m], shapes (T, k, N), a few parameters at a time."""
    entries: Callable[[RobotDescription], tuple[str, ...]] = lambda robot: ()
    """Entries of a description that hold its parameters; none if no description does."""
    applied: Callable[[RobotDescription, Array], RobotDescription] = lambda robot, parameters: robot
    """The robot with parameters (K,) in those entries."""
    is_held: bool = False
    """Whether the fit is held near the description; friction is not, which is unknown before it is measured."""
    least: float = -np.inf
    """Smallest value, as a share of the parameter's size: of its description, or of the torque that its motor has."""

    def torque(self, robot: RobotDescription, motion: JointMotion, parameters: Array) -> Array:
        """Motor torque of `parameters` (K,), motor side [N m], shape (T, N)."""
        total, start = np.zeros_like(motion.motor_dq), 0
        for columns in self.columns(robot, motion):
            stop = start + columns.shape[1]
            total += np.einsum("tkn,k->tn", columns, parameters[start:stop])
            start = stop
        return total


def read_description(robot: RobotDescription, terms: Sequence[Term]) -> Array:
    """Return the parameters of all `terms` as the description has them, shape (K,)."""
    return np.concatenate([term.described(robot) for term in terms])


def columns_of(robot: RobotDescription, terms: Sequence[Term], motion: JointMotion) -> Array:
    """Motor torque of each parameter of all `terms` at 1, motor side [N m], shape (T, K, N)."""
    return np.concatenate([part for term in terms for part in term.columns(robot, motion)], axis=1)


def per_parameter(robot: RobotDescription, terms: Sequence[Term], value: Callable[[Term], float]) -> NDArray[Any]:
    """A `value` of each term, once for each of its parameters, shape (K,)."""
    return np.repeat([value(term) for term in terms], [len(term.labels(robot)) for term in terms])


def _with_coulomb(robot: RobotDescription, parameters: Array) -> RobotDescription:
    """The robot with Coulomb torques; its breakaway torques, which cannot be below, keep their ratio to them."""
    friction = robot.friction
    static = np.maximum(friction.static * (parameters / friction.coulomb), parameters)
    return replace(robot, friction=replace(friction, coulomb=parameters, static=static))


def _of_each_motor(name: str, unit: str, per: Callable[[JointMotion], Array], **more: object) -> Term:
    """A term with one parameter for each motor, `per` of which its torque [N m] is (T, N); none is described unless."""

    def columns(robot: RobotDescription, motion: JointMotion) -> Iterator[Array]:
        own, motors = per(motion), np.arange(robot.n_joints)
        found = np.zeros((len(own), robot.n_joints, robot.n_joints))
        found[:, motors, motors] = own
        yield found

    common: dict[str, object] = {
        "labels": lambda robot: tuple(f"{name}.{joint}" for joint in robot.joints),
        "units": lambda robot: (unit,) * robot.n_joints,
        "described": lambda robot: np.zeros(robot.n_joints),
    }
    return Term(name=name, columns=columns, **(common | more))  # type: ignore[arg-type]  # a table of settings


BODIES = Term(
    name="bodies",
    labels=lambda robot: tuple(f"{body.name}.{parameter}" for body in bodies_of(robot) for parameter in PARAMETERS),
    units=lambda robot: UNITS * len(bodies_of(robot)),
    described=lambda robot: np.concatenate([body.parameters for body in bodies_of(robot)]),
    columns=lambda robot, motion: map(
        robot.drive.motor_torque, body_torque_columns(robot, motion.q, motion.dq, motion.ddq)
    ),
    entries=lambda robot: tuple(
        f"{group}.{name}"
        for group in (["links"] if len(bodies_of(robot)) == robot.n_joints else ["links", "tool"])
        for name in ("mass", "com", "inertia")
    ),
    applied=lambda robot, parameters: with_bodies(robot, parameters.reshape(-1, 10)),
    is_held=True,
)
"""Links and tool: inertia, Coriolis and centrifugal torque, gravity."""

SPRINGS = Term(
    name="springs",
    labels=lambda robot: tuple(f"springs.{spring.name}" for spring in robot.springs),
    units=lambda robot: ("1",) * len(robot.springs),
    described=lambda robot: np.ones(len(robot.springs)),
    columns=lambda robot, motion: (
        robot.drive.motor_torque(RigidArm(replace(robot, springs=(spring,))).spring_torque(motion.q))[:, None]
        for spring in robot.springs
    ),
)
"""Springs between links, e.g. a counterbalance: a factor on the force of each, 1 as described."""

ROTOR_INERTIA = _of_each_motor(
    "rotor_inertia",
    "kg m^2",
    lambda motion: motion.motor_ddq,
    described=lambda robot: robot.drive.rotor_inertia,
    entries=lambda robot: ("drive.rotor_inertia",),
    applied=lambda robot, parameters: replace(robot, drive=replace(robot.drive, rotor_inertia=parameters)),
    is_held=True,
    least=_ABOVE_ZERO,
)
"""Motor and gear input: J times motor acceleration."""

COULOMB = _of_each_motor(
    "coulomb",
    "N m",
    lambda motion: np.sign(motion.motor_dq),
    described=lambda robot: robot.friction.coulomb,
    entries=lambda robot: ("friction.coulomb", "friction.static"),
    applied=_with_coulomb,
    least=_ABOVE_ZERO,
)

VISCOUS = _of_each_motor(
    "viscous",
    "N m s/rad",
    lambda motion: motion.motor_dq,
    described=lambda robot: robot.friction.viscous,
    entries=lambda robot: ("friction.viscous",),
    applied=lambda robot, parameters: replace(robot, friction=replace(robot.friction, viscous=parameters)),
    least=0.0,
)

OFFSET = _of_each_motor("offset", "N m", lambda motion: np.ones_like(motion.motor_dq))
"""A constant: an offset of the torque signal, or half the difference of Coulomb friction in both directions."""

VISCOUS_ASYMMETRY = _of_each_motor("viscous_asymmetry", "N m s/rad", lambda motion: np.abs(motion.motor_dq))
"""Half the difference of viscous friction in both directions, times the absolute motor speed."""

TERMS = (BODIES, SPRINGS, ROTOR_INERTIA, COULOMB, VISCOUS, OFFSET, VISCOUS_ASYMMETRY)
"""All terms there are, in the order in which their parameters stand."""

DEFAULT_TERMS = ("bodies", "rotor_inertia", "coulomb", "viscous", "offset")
"""What is fitted unless asked otherwise; springs stay as described, and friction is the same in both directions."""


def terms_named(names: Sequence[str]) -> tuple[Term, ...]:
    """Terms by name, in the order of TERMS; none, or an unknown one, is an error."""
    known = [term.name for term in TERMS]
    for name in names:
        check_choice("term", name, known)
    if not names:
        raise FFGymError(f"There is nothing to fit: no terms. Available: {', '.join(known)}.")
    return tuple(term for term in TERMS if term.name in names)
