"""What a small effect adds along a nominal replay: the push that a candidate gives motors, links and springs.

What it adds on the motor side changes that motor's torque and nothing else, as the motors move as measured; what it
adds behind the gearbox bends the springs.
"""

from dataclasses import dataclass, replace

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.log.derivatives import derivatives_of_motions
from ffgym.diagnosis.replay import Replay
from ffgym.diagnosis.replay.bristles import along_speed
from ffgym.diagnosis.replay.sameness import alike, same_links
from ffgym.effects import NativeEffect, ResolverEffect, TorqueEffect
from ffgym.effects.along import torques_along
from ffgym.effects.effect import Effect
from ffgym.robot import RobotDescription
from ffgym.robot.friction import LuGreParameters


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
    joint_ddq: Array | None = None
    """Its acceleration."""


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
    if not same_links(other, robot):
        links = run.link_torque(other) - run.own_link_torque
    return Push(motor=motor, links=links, spring=spring)


def _friction(run: Replay, friction: LuGreParameters, faster: Array | float) -> Array:
    """Friction torque of another model, or at joint speeds that differ by `faster` [rad/s] wherever motors move."""
    drive, log = run.robot.drive, run.log
    slip = log.slip_dq + np.where(log.slip_dq != 0, faster, 0.0)
    return along_speed(friction, drive.motor_angle(slip), drive.motor_angle(log.dq + faster), log.dt).torque


def _more(other: Array, nominal: Array) -> Array:
    """Difference of two arrays that may have infinite entries where nothing changes."""
    return np.subtract(other, nominal, out=np.zeros_like(nominal), where=other != nominal)


def misread_push(run: Replay, effect: ResolverEffect) -> Push:
    """Of wrong readings at all motors, which truly moved otherwise; what they ask of the links is left to each."""
    drive = run.robot.drive
    error = effect.error(run.state.motor_angle, run.state.motor_speed)
    return moved(run, -drive.joint_angle(error.angle))


def misread_on(run: Replay, misread: Push, joint: int) -> Push:
    """Of the wrong reading at one motor alone."""
    alone = only_joint(misread, joint)
    if misread.joint_ddq is None:
        return alone
    return replace(alone, links=run.links.mass[..., joint] * misread.joint_ddq[..., joint, None])


def moved(run: Replay, further: Array) -> Push:
    """Of motors that truly were `further` [rad] than read, behind the gearbox; it goes through the motion's filter."""
    drive, log = run.robot.drive, run.log
    joint_q = log.sampling.motion_filter(further, log.dt)
    joint_dq, joint_ddq = derivatives_of_motions(joint_q, log.lengths, log.dt)
    friction = _friction(run, run.robot.friction, joint_dq)
    return Push(
        motor=drive.rotor_inertia * drive.motor_angle(joint_ddq) + friction - run.bristles.torque,
        links=np.matmul(run.links.mass, joint_ddq[..., None])[..., 0],
        joint_q=joint_q,
        joint_ddq=joint_ddq,
    )


def only_joint(push: Push, joint: int) -> Push:
    """A push of effects on all joints, that of one of them alone."""

    def kept(values: Array | None) -> Array | None:
        if values is None:
            return None
        alone = np.zeros_like(values)
        alone[..., joint] = values[..., joint]
        return alone

    return replace(
        push, motor=kept(push.motor), links=kept(push.links), spring=kept(push.spring), joint_q=kept(push.joint_q)
    )
