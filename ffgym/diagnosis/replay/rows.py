r"""Motor-driven replay: measured motors drive a model's arm forward, and its motor side is inverted.

.. math::
    M(q) (\ddot q + \ddot\delta) + h = \tau_l + \tau_{link}, \quad \tau_l = -(K \delta + d \dot\delta) + \tau_{spring},
    \quad u = J_m \ddot\theta + \tau_f - \tau_{motor} + G^{-T} \tau_l

No controller takes part, so that nothing of the log's feedback can hide or invent an effect, and only the second
derivative of the motor angle is needed. An effect acts by its own code, as it does in a simulation.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, fields, is_dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.computing import FAILED
from ffgym.diagnosis.log import Log
from ffgym.diagnosis.replay.links import LinkTerms, bending_of, link_terms, terms_beside
from ffgym.diagnosis.replay.springs import Deflection, Springs
from ffgym.diagnosis.replay.states import (
    Bristles,
    along_links,
    arm_effects,
    deflect,
    deflect_by_shares,
    friction_on_motors,
    leave_on_motors,
    state_of,
)
from ffgym.diagnosis.replay.structure import (
    StructureKey,
    StructureTerms,
    Sway,
    find_structure,
    structure_terms,
    sway_of,
)
from ffgym.diagnosis.settings import settings
from ffgym.effects import State, TorqueEffect
from ffgym.effects.along import torques_along
from ffgym.effects.effect import LinkBrake
from ffgym.effects.together import add, sum_along
from ffgym.effects.transmission.arm_friction import LinkFriction
from ffgym.logs.preparation import differentiate_motions
from ffgym.robot import RigidArm, RobotDescription
from ffgym.simulation.plant import Machine

_OF_LINKS = ("bodies", "tool", "springs", "gravity", "kinematics")
"""Parts of a description that decide what links ask for."""


def have_same_links(one: RobotDescription, other: RobotDescription) -> bool:
    """Tell whether links of two robots take the same torque in the same motion."""
    return all(have_same_numbers(getattr(one, part), getattr(other, part)) for part in _OF_LINKS)


def _rub_alike(one: RobotDescription, other: RobotDescription) -> bool:
    """Tell whether motors of two robots have the same friction in the same motion, of both sides together."""
    geared = all(have_same_numbers(getattr(one.drive, p), getattr(other.drive, p)) for p in ("gear_ratio", "coupling"))
    return geared and have_same_numbers(replace(one.friction, arm_share=other.friction.arm_share), other.friction)


def have_same_numbers(one: Any, other: Any) -> bool:
    """Tell whether two parts of a description have the same numbers."""
    if one is other:
        return True
    if is_dataclass(one) and is_dataclass(other) and type(one) is type(other):
        return all(have_same_numbers(getattr(one, f.name), getattr(other, f.name)) for f in fields(one))
    if isinstance(one, tuple | list) and isinstance(other, tuple | list):
        return len(one) == len(other) and all(have_same_numbers(a, b) for a, b in zip(one, other, strict=True))
    return bool(np.array_equal(one, other))


@dataclass(frozen=True, kw_only=True, eq=False)
class Replay:
    """Motion and torques of a machine whose motors move as measured; (T, M, N) each."""

    read: Log
    """Log as resolvers read the motors, which is what the servo acts on."""
    log: Log
    """Log as motors truly moved."""
    machine: Machine
    robot: RobotDescription
    """Description with the effects that other numbers bring about."""
    links: LinkTerms
    """Terms of the links."""
    springs: Springs
    deflection: Deflection
    bristles: Bristles
    state: State
    """States of all joints; `motor_torque` is the model's."""
    torque: Array
    """Motor torque that the motion takes [N m], motor side."""
    sway: Sway | None = None
    """Motion of a base or links that give way."""

    @cached_property
    def coarse_springs(self) -> tuple[int, Springs]:
        """The springs at every n-th sample, which is a divisor of the rows' stride, at most COARSE apart; and n."""
        stride, dt = self.log.sampling.stride, self.log.dt
        every = max(
            n for n in range(1, stride + 1) if stride % n == 0 and (n == 1 or n * dt <= settings().replay.spring_step)
        )
        return every, self.springs if every == 1 else self.springs.coarser(every)

    @cached_property
    def link_q(self) -> Array:
        """Angle of the links [rad], link side."""
        return self.log.q + self.deflection.angle

    @cached_property
    def friction_along_links(self) -> Array:
        """Torque of all friction, as if it were behind the elasticity, in units of the motors [N m], (T, M, N)."""
        return along_links(self.robot, self.log.dq + self.deflection.rate, self.log.dt).whole

    def link_torque(self, robot: RobotDescription) -> Array:
        """Compute the torque that the links of a robot take in this motion [N m], link side, (T, M, N)."""
        terms = link_terms(RigidArm(robot), self.link_q, self.log.dq + self.deflection.rate, self.log.dt)
        return terms.torque(self.log.ddq + self.deflection.acceleration)

    @cached_property
    def own_link_torque(self) -> Array:
        """The same of its own links."""
        return self.link_torque(self.robot)

    @cached_property
    def _structures(self) -> dict[StructureKey, StructureTerms]:
        return {}

    def structure_terms(self, parts: StructureKey) -> StructureTerms:
        """Terms of the links on a structure of which some parts give way; they are kept."""
        if parts not in self._structures:
            self._structures[parts] = structure_terms(self.log, self.robot, parts, self.links.bent)
        return self._structures[parts]

    @cached_property
    def arm(self) -> RigidArm:
        """The links of the robot."""
        return RigidArm(self.robot)

    @cached_property
    def tool_position(self) -> Array:
        """Position of the tool on links and a base that do not give way [m], (T, M, 3)."""
        q = self.link_q
        return self.arm.tcp_position(q.reshape(-1, q.shape[-1])).reshape(*q.shape[:2], 3)

    @cached_property
    def tool_jacobian(self) -> Array:
        """Jacobian of the tool's position by the joints at the rows that are compared, (R, M, 3, N)."""
        q = self.link_q[self.log.sampling.at]
        jacobian = self.arm.jacobian(q.reshape(-1, q.shape[-1]))[:, :3]
        return jacobian.reshape(*q.shape[:2], 3, q.shape[-1])


def replay(
    log: Log,
    machine: Machine,
    like: Replay | None = None,
    nearby: Replay | None = None,
    *,
    beside: Replay | None = None,
    bristles: Bristles | None = None,
    deflection: Deflection | None = None,
    exact: bool = False,
) -> Replay:
    """Replay a log on a machine.

    Args:
        log: motions.
        machine: whose motors move so.
        like: replay of the same log on another machine, of which is taken what is the same.
        nearby: replay on the same machine of motions that differ by noise alone, of which the terms of the links are
            taken: poses differ by too little to show in them.
        beside: replay of the same log on a machine whose masses differ by errors of calibration: what that changes in
            the terms of the links is small, and is known well enough at fewer samples.
        bristles: friction along the motion, if it is known already.
        deflection: of the joints, if it is known already.
        exact: whether links that bend ask for what they do there, not for what slopes about the measured motion say;
            it takes a little longer.
    """
    # another replay lends the terms of its links if log and links are the same, and its springs if drives are, too
    robot, read = machine.physical, log
    drive, log = robot.drive, _truly(log, machine)
    if like is not None and (like.log is not log or not have_same_links(like.robot, robot)):
        like = None
    alike_driven = like if like is not None and have_same_numbers(like.robot.drive, drive) else None
    # terms of the links: known ones, those of other masses, or new ones
    known = like if like is not None else nearby
    if known is not None:
        links, rough = known.links, known.deflection.angle[0]
    elif (
        beside is not None
        and beside.log is log
        and have_same_numbers(beside.robot.kinematics, robot.kinematics)
        and np.all(beside.robot.drive.is_rigid == drive.is_rigid)
    ):
        elastic = np.flatnonzero(~drive.is_rigid)
        links = terms_beside(RigidArm(robot), beside.links, log.q, log.dq, log.ddq, log.dt, elastic)
        rough = beside.deflection.angle[0]
    else:
        links, rough = _links(log, robot)
    # motors with their friction, which is that of another replay if only another part of it is behind the elasticity
    if bristles is None and like is not None and _rub_alike(like.robot, robot):
        bristles = leave_on_motors(robot, like.bristles)
    elif bristles is None:
        bristles = friction_on_motors(robot, log.slip_dq, log.dq, log.dt)
    state, on_arm, sway = state_of(log, machine, bristles), arm_effects(machine), None
    # springs under what links ask for, on a structure that may give way
    if alike_driven is not None:
        springs = alike_driven.springs
    else:
        stiffness, damping = drive.joint_stiffness, drive.joint_damping
        springs = Springs(mass=links.mass, stiffness=stiffness, damping=damping, dt=log.dt, bending=links.bending)
    if (parts := find_structure(machine)) is not None:
        terms = structure_terms(log, robot, parts, links.bent) if like is None else like.structure_terms(parts)
        sway = sway_of(log, machine, terms)
    rigid_torque = links.torque(log.ddq) + (0.0 if sway is None else sway.torque)
    # deflections of another replay hold if nothing that acts on the arm differs
    stands = sway is None and alike_driven is not None and alike_driven.sway is None
    if alike_driven is not None and stands and _bend_alike(on_arm, arm_effects(alike_driven.machine)):
        deflection = alike_driven.deflection
    elif deflection is None:
        deflection = deflect(springs, state, on_arm, -rigid_torque, rough, log.dt)
    if exact and len(springs.elastic):
        deflection, beyond = _beyond_slopes(log, robot, links, springs, deflection)
        rigid_torque = rigid_torque + beyond
    # load of the motors
    needed = rigid_torque + springs.bending_torque(deflection)
    state = state.with_values(deflection=deflection.angle, deflection_rate=deflection.rate, rigid_load=needed)
    added = sum_along([effect for effect in on_arm if not isinstance(effect, LinkBrake)], state, log.dt)
    on_links = add(added.link, deflection.braking)
    if on_links is not None:
        needed = needed - on_links
    state.set_values(wound=added.spring, rigid_load=needed)
    torque = drive.rotor_inertia * drive.motor_angle(log.ddq) + bristles.torque + drive.motor_torque(needed)
    # motor-side torque effects, those that act on what the drive commands last: they see all that it must give
    motor = added.motor
    of_motors = [effect for effect in machine.torque_effects_without_engine if effect.side == "motor"]
    for effect in sorted(of_motors, key=lambda effect: (effect.code.startswith("M"), effect.name)):
        state.set_values(motor_torque=torque if motor is None else torque - motor)
        motor = add(motor, torques_along(effect, state, log.dt).motor)
    torque = torque if motor is None else torque - motor
    state.set_values(motor_torque=torque)
    return Replay(
        read=read,
        log=log,
        machine=machine,
        robot=robot,
        links=links,
        springs=springs,
        deflection=deflection,
        bristles=bristles,
        state=state,
        torque=torque,
        sway=sway,
    )


def bend_with_shares(run: Replay, machines: Sequence[Machine]) -> Sequence[Deflection | None]:
    """Deflections of machines that have other shares of the friction of a run on their links, side by side.

    None for each that a replay must bend by itself: they differ by more, or one does not stay where its motors are.
    """
    drive, others = run.robot.drive, [machine.physical for machine in machines]
    acting = [effect for machine in machines for effect in arm_effects(machine)]
    alike = all(have_same_numbers(one.drive, drive) for one in others) and run.sway is None
    if machines and alike and all(isinstance(effect, LinkFriction) for effect in acting):
        asked, start = -run.links.torque(run.log.ddq), run.deflection.angle[0]
        shares = np.stack([one.arm_share for one in others])
        with suppress(*FAILED):
            return deflect_by_shares(run.springs, run.state, run.robot, asked, start, shares)
    return [None] * len(machines)


def lends_deflection(run: Replay, log: Log, machine: Machine) -> bool:
    """Tell whether joints bend in a replay as they would in one of a log on another machine."""
    alike = run.log is log and run.sway is None and have_same_numbers(run.robot.drive, machine.physical.drive)
    return alike and _bend_alike(arm_effects(run.machine), arm_effects(machine))


def _bend_alike(some: Sequence[TorqueEffect], others: Sequence[TorqueEffect]) -> bool:
    """Tell whether joints bend alike under effects: under none, or under the same friction on the links."""
    if not all(isinstance(effect, LinkFriction) for effect in (*some, *others)):
        return False
    return have_same_numbers(tuple(some), tuple(others))


def _beyond_slopes(
    log: Log, robot: RobotDescription, links: LinkTerms, springs: Springs, bent: Deflection
) -> tuple[Deflection, Array]:
    """Deflections after a step of Newton's method, and the torque of links (T, M, N) that slopes do not tell [N m]."""
    there = link_terms(RigidArm(robot), log.q + bent.angle, log.dq + bent.rate, log.dt)
    beyond: Array = there.torque(log.ddq + bent.acceleration) - links.torque(log.ddq) - springs.bending_torque(bent)
    more = springs.bent_by(-beyond[..., None])
    return Deflection(
        angle=bent.angle + more.angle[..., 0],
        rate=bent.rate + more.rate[..., 0],
        acceleration=bent.acceleration + more.acceleration[..., 0],
    ), beyond


def _truly(log: Log, machine: Machine) -> Log:
    """The log with the motion that the motors made where resolvers err; the error hardly changes over itself.

    What was read went through the low-pass of the motion, and so does the error.
    """
    if not machine.resolver_effects:
        return log
    drive, sampling = machine.physical.drive, log.sampling
    angle = drive.motor_angle(log.q)
    read, _ = machine.read_by_resolver(angle, drive.motor_angle(log.dq))
    q = log.q - sampling.motion_filter(drive.joint_angle(read - angle), log.dt)
    dq, ddq = differentiate_motions(q, log.lengths, log.dt)
    slip = log.slip_dq + np.where(log.slip_dq != 0, dq - log.dq, 0.0)
    return replace(log, q=q, dq=dq, ddq=ddq, slip_dq=slip)


def _links(log: Log, robot: RobotDescription) -> tuple[LinkTerms, Array]:
    """Terms of the links where they hang in their springs, and the deflection at the first sample."""
    elastic = ~robot.drive.is_rigid
    bent = np.zeros_like(log.q)
    arm = RigidArm(robot)
    links = link_terms(arm, log.q, log.dq, log.dt)
    if not elastic.any():
        return links, bent[0]
    bent[..., elastic] = -links.torque(log.ddq)[..., elastic] / robot.drive.joint_stiffness[elastic]
    links = link_terms(arm, log.q + bent, log.dq, log.dt)
    bending = bending_of(arm, log.q + bent, log.dq, log.ddq, log.dt, np.flatnonzero(elastic))
    unbent = links.bias - np.matmul(bending.place, bent[..., None])[..., 0]
    return replace(links, bias=unbent, bending=bending, bent=bent), bent[0]
