r"""What a small effect changes in a replay, to first order: the difference that a candidate would have to explain.

Each effect acts along the nominal replay. What it adds on the motor side changes that motor's torque and nothing else, as
the motors move as measured. What it adds behind the gearbox, a push p, bends the springs by

.. math:: M \Delta\ddot\delta + d \Delta\dot\delta + K \Delta\delta = p

which changes the load of the motors and the place of the tool.
"""

from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any

import numpy as np

from ffgym.diagnosis.replay.bristles import along_speed
from ffgym.diagnosis.replay.link_terms import link_terms
from ffgym.diagnosis.replay.replay import Replay
from ffgym.effects import NativeEffect, ResolverEffect, TorqueEffect
from ffgym.effects.along import torques_along
from ffgym.effects.effect import Effect
from ffgym.friction import LuGreParameters
from ffgym.robot import RobotDescription
from ffgym.types import Array

_OF_LINKS = ("bodies", "tool", "springs", "gravity", "kinematics")
"""Parts of a description that decide what links ask for."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Push:
    """What an effect adds to the balance of torques along a replay, (T, M, N) each; None is nothing."""

    motor: Array | None = None
    """More torque that motors must give, motor side [N m]."""
    links: Array | None = None
    """More torque that links ask for at the nominal motion, link side [N m]."""
    spring: Array | None = None
    """More torque of springs at the nominal deflection, link side [N m]."""
    joint_q: Array | None = None
    """How much further the gearbox output truly was than read, link side [rad]."""


def push_of(run: Replay, effect: Effect) -> Push:
    """What `effect` adds along a nominal replay."""
    if isinstance(effect, TorqueEffect):
        added = torques_along(effect, run.state, run.log.dt)
        return Push(
            motor=None if added.motor is None else -added.motor,
            links=None if added.link is None else -added.link,
            spring=added.spring,
        )
    return of_numbers(run, effect.in_description(run.robot)) if isinstance(effect, NativeEffect) else Push()


def of_numbers(run: Replay, other: RobotDescription) -> Push:
    """Of a robot with other numbers: what each group of them changes by itself."""
    robot = run.robot
    log, drive = run.log, run.robot.drive
    motor, links, spring = None, None, None
    if not alike(other.friction, robot.friction):
        motor = _friction(run, other.friction, 0.0) - run.bristles.torque
    if other.drive is not drive:
        if np.any(other.drive.rotor_inertia != drive.rotor_inertia):
            more = (other.drive.rotor_inertia - drive.rotor_inertia) * drive.motor_angle(log.ddq)
            motor = more if motor is None else motor + more
        stiffer, damped = (
            _more(other.drive.joint_stiffness, drive.joint_stiffness),
            _more(other.drive.joint_damping, drive.joint_damping),
        )
        if np.any(stiffer) or np.any(damped):
            spring = -(stiffer * run.deflection.angle + damped * run.deflection.rate)
    if not all(alike(getattr(other, part), getattr(robot, part)) for part in _OF_LINKS):
        terms = link_terms(other, run.link_q, log.dq, log.dt)
        acceleration = log.ddq + run.deflection.acceleration
        links = terms.torque(acceleration) - run.links.torque(acceleration)
    return Push(motor=motor, links=links, spring=spring)


def _friction(run: Replay, friction: LuGreParameters, faster: Array | float) -> Array:
    """Friction torque of another model, or at joint speeds that differ by `faster` [rad/s] wherever motors move."""
    drive, log = run.robot.drive, run.log
    slip = log.slip_dq + np.where(log.slip_dq != 0, faster, 0.0)
    return along_speed(friction, drive.motor_angle(slip), drive.motor_angle(log.dq + faster), log.dt).torque


def _more(other: Array, nominal: Array) -> Array:
    """Difference of two arrays that may have infinite entries where nothing changes."""
    return np.subtract(other, nominal, out=np.zeros_like(nominal), where=other != nominal)


def misread_push(run: Replay, effect: ResolverEffect, joint: int) -> Push:
    """Of a wrong reading at one motor, which truly moved otherwise."""
    drive, alone = run.robot.drive, np.zeros(run.robot.n_joints)
    alone[joint] = 1.0
    error = effect.error(run.state.motor_angle, run.state.motor_speed)
    return moved(run, -drive.joint_angle(error.angle * alone), -drive.joint_angle(error.speed * alone))


def moved(run: Replay, joint_q: Array, joint_dq: Array) -> Push:
    """Of motors that truly were at `joint_q` [rad] more than read, behind the gearbox, with speeds `joint_dq`."""
    drive, log = run.robot.drive, run.log
    joint_ddq = np.gradient(joint_dq, log.dt, axis=0)
    friction = _friction(run, run.robot.friction, joint_dq)
    return Push(
        motor=drive.rotor_inertia * drive.motor_angle(joint_ddq) + friction - run.bristles.torque,
        links=np.matmul(run.links.mass, joint_ddq[..., None])[..., 0],
        joint_q=joint_q,
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class Change:
    """What a push changes in what is compared, at R rows."""

    torque: Array
    """Of the motors, motor side [N m], shape (R, M, N)."""
    link: Array
    """Of the links, link side [rad], shape (R, M, N)."""


def changes(run: Replay, pushes: list[Push]) -> list[Change]:
    """What each of several pushes changes; those behind the gearbox are solved for together."""
    log, sampling = run.log, run.log.sampling
    none = np.zeros_like(log.q)
    behind = [push for push in pushes if push.links is not None or push.spring is not None]
    bent: dict[int, tuple[Array, Array, Array]] = {}
    if behind:
        load = [(none if p.spring is None else p.spring) - (none if p.links is None else p.links) for p in behind]
        flown = run.springs.bent_by(np.stack(load, axis=-1))
        for i, push in enumerate(behind):
            bent[id(push)] = (flown.angle[..., i], flown.rate[..., i], flown.acceleration[..., i])
    return [_change(run, push, bent.get(id(push))) for push in pushes] if sampling is not None else []


def _change(run: Replay, push: Push, bent: tuple[Array, Array, Array] | None) -> Change:
    log, drive = run.log, run.robot.drive
    torque = np.zeros_like(log.q) if push.motor is None else push.motor
    link = np.zeros_like(log.q) if push.joint_q is None else push.joint_q
    if bent is not None:
        angle, rate, acceleration = bent
        rigid = drive.is_rigid
        state = run.state
        carried = -(state.joint_stiffness * angle + state.joint_damping * rate)
        if push.spring is not None:
            carried = carried + push.spring
        if rigid.any():
            asked = np.matmul(run.links.mass, acceleration[..., None])[..., 0]
            asked = asked if push.links is None else asked + push.links
            carried = np.where(rigid, asked, carried)
        torque = torque + drive.motor_torque(carried)
        link = link + angle
    return Change(torque=log.sampling(torque), link=log.sampling(link))


def only_joint(push: Push, joint: int) -> Push:
    """A push of effects on all joints, that of one of them alone."""

    def kept(values: Array | None) -> Array | None:
        if values is None:
            return None
        alone = np.zeros_like(values)
        alone[..., joint] = values[..., joint]
        return alone

    return replace(push, motor=kept(push.motor), links=kept(push.links), spring=kept(push.spring))


def alike(one: Any, other: Any) -> bool:
    """Whether two parts of a description have the same numbers."""
    if one is other:
        return True
    if is_dataclass(one) and is_dataclass(other) and type(one) is type(other):
        return all(alike(getattr(one, f.name), getattr(other, f.name)) for f in fields(one))
    if isinstance(one, tuple | list) and isinstance(other, tuple | list):
        return len(one) == len(other) and all(alike(a, b) for a, b in zip(one, other, strict=True))
    return bool(np.array_equal(one, other))
