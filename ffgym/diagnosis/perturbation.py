r"""Perturbation of a nominal replay by a small effect, and the change of each channel by it, to first order.

On the motor side it changes that motor's torque and nothing else, as the motors move as measured; behind the gearbox it
bends the springs.

A torque p bends them by

.. math:: M \Delta\ddot\delta + d \Delta\dot\delta + K \Delta\delta = p

which changes the load of the motors and the place of the tool.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields

import numpy as np

from ffgym.core.types import Array, IntArray
from ffgym.diagnosis.replay import Replay, predict, replay
from ffgym.diagnosis.replay.channels import delay
from ffgym.diagnosis.replay.rows import have_same_links, have_same_numbers
from ffgym.diagnosis.replay.springs import Deflection
from ffgym.diagnosis.replay.states import along_speed
from ffgym.diagnosis.residual import Channel
from ffgym.effects import Effect, NativeEffect, TorqueEffect
from ffgym.effects.along import torques_along
from ffgym.effects.together import add
from ffgym.logs.preparation import differentiate_motions
from ffgym.robot import RobotDescription
from ffgym.simulation.plant import Machine


@dataclass(frozen=True, kw_only=True, eq=False)
class Perturbation:
    """Torques and motion that an effect adds along a replay, (T, M, N) each; None is nothing."""

    motor: Array | None = None
    """More torque that motors must give, motor side [N m]."""
    links: Array | None = None
    """More torque that links ask for at the nominal motion, link side [N m]."""
    spring: Array | None = None
    """More torque of springs at the nominal deflection, link side [N m]."""
    joint_q: Array | None = None
    """Angle by which the gearbox output truly was further than read, link side [rad]."""
    joint_ddq: Array | None = None
    """Its acceleration."""

    def plus(self, more: "Perturbation", sign: float = 1.0) -> "Perturbation":
        """Add another perturbation, or subtract it."""
        found = {}
        for name in (f.name for f in fields(Perturbation)):
            other = getattr(more, name)
            found[name] = add(getattr(self, name), None if other is None else sign * other)
        return Perturbation(**found)

    def select_joint(self, joint: int) -> "Perturbation":
        """Select one joint of a perturbation of all joints."""
        found = {}
        for name, values in ((f.name, getattr(self, f.name)) for f in fields(Perturbation)):
            if values is not None:
                found[name] = np.zeros_like(values)
                found[name][..., joint] = values[..., joint]
        return Perturbation(**found)


def perturb(run: Replay, effect: Effect) -> Perturbation:
    """Compute the perturbation by `effect` along a nominal replay."""
    if isinstance(effect, TorqueEffect):
        added = torques_along(effect, run.state, run.log.dt)
        return Perturbation(
            motor=None if added.motor is None else -added.motor,
            links=None if added.link is None else -added.link,
            spring=added.spring,
        )
    return (
        perturb_numbers(run, effect.in_description(run.robot)) if isinstance(effect, NativeEffect) else Perturbation()
    )


def perturb_numbers(run: Replay, other: RobotDescription) -> Perturbation:
    """Compute the perturbation by a robot with other numbers, the sum of what each group of them changes by itself."""
    robot, drive = run.robot, run.robot.drive
    motor, links, spring = None, None, None

    def more(name: str) -> Array:
        """Difference of a number of the drive; rigid joints have infinite stiffness, which does not change."""
        new, old = getattr(other.drive, name), getattr(drive, name)
        return np.subtract(new, old, out=np.zeros_like(old), where=new != old)

    # motor side: friction along the same motion, and torque that accelerates rotors
    if not have_same_numbers(other.friction, robot.friction):
        motor, links = _change_friction(run, other)
    if np.any(heavier := more("rotor_inertia")):
        motor = add(motor, heavier * drive.motor_angle(run.log.ddq))
    # springs: torque that other stiffness gives at the same deflection
    stiffer, damped = more("joint_stiffness"), more("joint_damping")
    if np.any(stiffer) or np.any(damped):
        spring = -(stiffer * run.deflection.angle + damped * run.deflection.rate)
    # links: torque of other masses along the same motion
    if not have_same_links(other, robot):
        links = add(links, run.link_torque(other) - run.own_link_torque)
    return Perturbation(motor=motor, links=links, spring=spring)


def _change_friction(run: Replay, robot: RobotDescription, faster: Array | None = None) -> tuple[Array, Array | None]:
    """Compute the torque that motors must give more, motor side, and that links ask for more, link side [N m].

    By the friction of another robot, or at joint speeds that differ by `faster` [rad/s] wherever motors move;
    (T, M, N) each.
    """
    log, own, behind = run.log, run.robot.arm_share, robot.arm_share
    # friction of all joints as if it were at the motors, and at the links; it is another one where numbers differ
    motor, links = run.bristles.whole, run.friction_along_links if np.any(own) or np.any(behind) else None
    whole, along = motor, links
    joints = _joints_of_other_friction(run.robot, robot) if faster is None else np.arange(run.robot.n_joints)
    if len(joints):
        friction, turn = robot.friction.select(joints), robot.drive.motor_angle
        slip, speed = log.slip_dq, log.dq
        if faster is not None:
            slip, speed = slip + np.where(slip != 0, faster, 0.0), speed + faster
        whole = motor.copy()
        whole[..., joints] = along_speed(friction, turn(slip)[..., joints], turn(speed)[..., joints], log.dt).whole
        if links is not None:
            speed = robot.drive.gear_ratio[joints] * (speed[..., joints] + run.deflection.rate[..., joints])
            along = links.copy()
            along[..., joints] = along_speed(friction, speed, speed, log.dt).whole
    pushed = (1 - behind) * whole - run.bristles.torque
    if links is None or along is None:
        return pushed, None
    return pushed, run.robot.drive.gear_ratio * (behind * along - own * links)


def _joints_of_other_friction(one: RobotDescription, other: RobotDescription) -> IntArray:
    """Find the joints whose friction is another one on both sides of their springs together; indices, (J,)."""
    names = [field.name for field in fields(one.friction) if field.name != "arm_share"]
    differ = [getattr(one.friction, name) != getattr(other.friction, name) for name in names]
    return np.flatnonzero(np.any(differ, axis=0))


def perturb_motion(run: Replay, further: Array) -> Perturbation:
    """Compute the perturbation by motors that truly were `further` [rad] than read, behind the gearbox, low-passed."""
    drive, log = run.robot.drive, run.log
    joint_q = log.sampling.motion_filter(further, log.dt)
    joint_dq, joint_ddq = differentiate_motions(joint_q, log.lengths, log.dt)
    friction, braked = _change_friction(run, run.robot, joint_dq)
    return Perturbation(
        motor=drive.rotor_inertia * drive.motor_angle(joint_ddq) + friction,
        links=add(np.matmul(run.links.mass, joint_ddq[..., None])[..., 0], braked),
        joint_q=joint_q,
        joint_ddq=joint_ddq,
    )


Parts = Mapping[tuple[Channel, int], Array]
"""Rows by channel and component, shape (R, M) each; what is not there does not change."""


def propagate(run: Replay, pushes: Sequence[Perturbation]) -> list[Parts]:
    """Propagate several perturbations to the channels that the log has; springs are solved for all together."""
    bent = _bend_springs(run, [push for push in pushes if push.links is not None or push.spring is not None])
    return [_change_channels(run, push, bent.get(id(push))) for push in pushes]


def _bend_springs(run: Replay, pushes: Sequence[Perturbation]) -> dict[int, tuple[Array, Array]]:
    """Bend the springs: rows of the deflection (R, M, N) [rad] and of the torque that the joints then carry.

    Solved at coarser samples than the replay: what is compared has no faster parts.
    """
    if not pushes:
        return {}
    # loads on the springs at coarse samples
    every, springs = run.coarse_springs
    sampling, none = run.log.sampling.coarser(every), np.zeros_like(run.log.q)
    load = np.empty((*springs.mass.shape[:-1], len(pushes)))
    for i, p in enumerate(pushes):
        load[..., i] = _smooth((none if p.spring is None else p.spring) - (0.0 if p.links is None else p.links), every)
    # deflections, and the torque that springs then carry; rigid joints carry all
    drive, state, asked = run.robot.drive, run.state, None
    if drive.is_rigid.any():
        bent = springs.bent_by(load)
        angle, rate, asked = sampling(bent.angle), sampling(bent.rate), sampling(springs.bending_torque(bent))
    else:
        angle, rate = (sampling(values) for values in springs.bend_in_place(load))
    carried = -(state.joint_stiffness[:, None] * angle + state.joint_damping[:, None] * rate)
    if asked is not None:
        carried = np.where(drive.is_rigid[:, None], asked, carried)
    return {id(push): (angle[..., i], carried[..., i]) for i, push in enumerate(pushes)}


def _smooth(values: Array, every: int) -> Array:
    """Average about every n-th sample."""
    if every == 1:
        return values
    total = np.cumsum(np.pad(values, ((1, 0), (0, 0), (0, 0))), axis=0)
    at = np.arange(0, len(values), every)
    low, high = np.maximum(at - every // 2, 0), np.minimum(at + (every + 1) // 2, len(values))
    means: Array = (total[high] - total[low]) / (high - low)[:, None, None]
    return means


def _change_channels(run: Replay, push: Perturbation, bent: tuple[Array, Array] | None) -> Parts:
    """Compute the change of each channel by a perturbation and the springs that it bends."""
    sampling, drive = run.log.sampling, run.robot.drive
    rows = (len(sampling.at), *run.log.q.shape[1:])
    # motor torque and link angle by the perturbation itself
    torque = np.zeros(rows) if push.motor is None else sampling(push.motor)
    link = np.zeros(rows) if push.joint_q is None else sampling(push.joint_q)
    # and by the springs that it bends
    if bent is not None:
        angle, carried = bent
        if push.spring is not None:
            carried = carried + sampling(push.spring)
        if push.links is not None and drive.is_rigid.any():
            carried = carried + np.where(drive.is_rigid, sampling(push.links), 0.0)
        torque = torque + drive.motor_torque(carried)
        link = link + angle
    # split by channel and component; the tool moves by the Jacobian
    parts: dict[tuple[Channel, int], Array] = {}
    for j in range(run.robot.n_joints):
        parts["torque", j] = torque[..., j]
        if run.log.link is not None:
            parts["link", j] = link[..., j]
    if run.log.tool is not None:
        tool = np.matmul(run.tool_jacobian, link[..., None])[..., 0]
        parts |= {("tool", k): tool[..., k] for k in range(3)}
    return parts


def shift_clocks(run: Replay, gone: Sequence[Effect], come: Sequence[Effect]) -> Parts:
    """Compute the change of the channels whose clocks are exchanged."""
    found: dict[tuple[Channel, int], Array] = {}
    of_channel: list[tuple[Channel, Array]] = [("torque", run.torque)]
    if run.log.link is not None:
        of_channel.append(("link", run.link_q))
    for channel, values in of_channel:
        before, after = delay(values, channel, gone, run.log), delay(values, channel, come, run.log)
        if before is not after:
            rows = run.log.sampling(after - before)
            found |= {(channel, j): rows[..., j] for j in range(run.robot.n_joints)}
    return found


def replay_change(
    run: Replay,
    machine: Machine,
    before: Mapping[Channel, Array] | None = None,
    deflection: Deflection | None = None,
) -> Parts:
    """Replay the log on another machine for the change of all channels: of effects with joints of their own.

    `before` is what the replay itself predicts, and `deflection` how joints of the other machine bend, if it is known.
    """
    before, after = before or predict(run), predict(replay(run.log, machine, run, deflection=deflection))
    return {(c, k): after[c][..., k] - rows[..., k] for c, rows in before.items() for k in range(rows.shape[2])}
