r"""Motor-driven replay: measured motors drive a model's arm forward, and its motor side is inverted.

.. math::
    M(q) (\ddot q + \ddot\delta) + h = \tau_l + \tau_{link}, \quad \tau_l = -(K \delta + d \dot\delta) + \tau_{spring},
    \quad u = J_m \ddot\theta + \tau_f - \tau_{motor} + G^{-T} \tau_l

No controller takes part, so that nothing of the log's feedback can hide or invent an effect, and only the second
derivative of the motor angle is needed. An effect acts by its own code, as it does in a simulation.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ffgym.control import servo_torque
from ffgym.diagnosis.log import Log
from ffgym.diagnosis.replay.bristles import Bristles, along_speed
from ffgym.diagnosis.replay.clocks import late
from ffgym.diagnosis.replay.link_terms import LinkTerms, link_terms
from ffgym.diagnosis.replay.sameness import alike, same_links
from ffgym.diagnosis.replay.springs import Deflection, Springs, resting
from ffgym.diagnosis.residual import Channel
from ffgym.effects import State, TorqueEffect, Torques, TrackerEffect
from ffgym.effects.along import samples, torques_along
from ffgym.plant import Climate, Machine
from ffgym.recordings import Recording
from ffgym.robot import RigidArm, RobotDescription
from ffgym.types import Array

_PASSES = 2
"""Times that the links are evaluated, the second time where they hang in their springs; see `identification`."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Replay:
    """What a machine does when its motors move as measured; (T, M, N) each."""

    read: Log
    """As resolvers read the motors, which is what the servo acts on."""
    log: Log
    """As motors truly moved."""
    machine: Machine
    robot: RobotDescription
    """With the effects that other numbers bring about."""
    links: LinkTerms
    """Where the links are."""
    springs: Springs
    deflection: Deflection
    bristles: Bristles
    state: State
    """Of all joints; `motor_torque` is the model's."""
    torque: Array
    """Motor torque that the motion takes [N m], motor side."""

    @cached_property
    def _coarse(self) -> dict[int, Springs]:
        return {}

    def coarse_springs(self, every: int) -> Springs:
        """The springs at every n-th sample, made once."""
        if every not in self._coarse:
            self._coarse[every] = self.springs if every == 1 else self.springs.coarser(every)
        return self._coarse[every]

    @cached_property
    def link_q(self) -> Array:
        """Where the links are [rad], link side."""
        return self.log.q + self.deflection.angle


def replay(log: Log, machine: Machine, like: Replay | None = None) -> Replay:
    """Replay a log on a machine.

    Args:
        log: motions.
        machine: whose motors move so.
        like: replay of the same log on another machine, of which is taken what is the same.
    """
    robot = machine.physical
    read, log = log, _truly(log, machine)
    if like is not None and (like.log is not log or not same_links(like.robot, robot)):
        like = None
    links, rough = (like.links, like.deflection.angle[0]) if like is not None else _links(log, robot)
    springs = Springs(
        mass=links.mass, stiffness=robot.drive.joint_stiffness, damping=robot.drive.joint_damping, dt=log.dt
    )
    same_drive = like is not None and alike(like.robot.drive, robot.drive)
    if like is not None and same_drive:
        springs = like.springs
    bristles = along_speed(
        robot.friction, robot.drive.motor_angle(log.slip_dq), robot.drive.motor_angle(log.dq), log.dt
    )
    state = state_of(log, machine, bristles)
    on_arm = _on_arm(machine)
    rigid_torque = links.torque(log.ddq)
    if like is not None and same_drive and not on_arm and not _on_arm(like.machine):
        deflection = like.deflection
    elif on_arm:
        deflection = _flown(springs, state, on_arm, -rigid_torque, rough, log.dt)
    else:
        bent = springs.bent_by(-rigid_torque[..., None])
        deflection = Deflection(
            angle=bent.angle[..., 0], rate=bent.rate[..., 0], acceleration=bent.acceleration[..., 0]
        )
    state = bent_state(state, deflection, robot)
    needed = rigid_torque + np.matmul(links.mass, deflection.acceleration[..., None])[..., 0]
    added = summed(on_arm, state, log.dt)
    if added.link is not None:
        needed = needed - added.link
    state = loaded_state(state, added, robot)
    base = robot.drive.rotor_inertia * robot.drive.motor_angle(log.ddq) + bristles.torque
    torque = base + robot.drive.motor_torque(needed)
    motor = added.motor
    for of_motor in _in_order(machine):
        state = replace(state, motor_torque=torque if motor is None else torque - motor)
        motor = _plus(motor, torques_along(of_motor, state, log.dt).motor)
    torque = torque if motor is None else torque - motor
    return Replay(
        read=read,
        log=log,
        machine=machine,
        robot=robot,
        links=links,
        springs=springs,
        deflection=deflection,
        bristles=bristles,
        state=replace(state, motor_torque=torque),
        torque=torque,
    )


def _on_arm(machine: Machine) -> list[TorqueEffect]:
    """Effects that depend on how joints bend."""
    return [effect for effect in machine.torque_effects if effect.side == "link" and not effect.is_null]


def predicted(run: Replay) -> dict[Channel, Array]:
    """What the log's channels would show, R rows each, through the log's low-pass."""
    log, sampling = run.log, run.log.sampling
    effects = run.machine.effects
    found: dict[Channel, Array] = {"torque": sampling(late(run.torque, "torque", effects, log))}
    if log.tool is not None:
        found["tool"] = sampling(tool_path(run))
    if log.link is not None:
        found["link"] = sampling(late(run.link_q, "link", effects, log))
    if log.feedback is not None and log.reference is not None:
        found["servo"] = sampling(servo_feedback(run.read, run.robot))
    return found


def tool_path(run: Replay) -> Array:
    """Tool positions as a tracker would see them [m], (T, M, 3)."""
    return tracked(run, run.machine)


def tracked(run: Replay, machine: Machine, every: int = 1) -> Array:
    """Tool positions of the replay as the tracker of another machine would see them [m], at every n-th sample."""
    q = run.link_q[::every]
    position = RigidArm(run.robot).tcp_position(q.reshape(-1, q.shape[-1])).reshape(*q.shape[:2], 3)
    effects = [effect for effect in machine.effects if isinstance(effect, TrackerEffect)]
    for i, recording in enumerate(run.log.recordings) if effects else ():
        n = -(-len(recording) // every)
        columns = {"timestamp": recording.t[::every]}
        columns |= {f"tcp.position.{axis}": position[:n, i, k] for k, axis in enumerate("xyz")}
        columns |= {f"link.position.{joint}": q[:n, i, j] for j, joint in enumerate(run.robot.joints)}
        exact = Recording(columns=columns, header=replace(recording.header, phases=()))
        for effect in effects:
            exact = effect.measured(exact, run.robot)
        position[:n, i] = exact.vector("tcp.position")
    return position


def servo_feedback(log: Log, robot: RobotDescription) -> Array:
    """Feedback torque of the documented servo on the measured error [N m], motor side, (T, M, N).

    The integral is that since the motion began; what it held before is a constant that nobody recorded.
    """
    if log.reference is None:
        raise ValueError("the log has no set-points")
    position, rate = log.reference
    error = position - robot.drive.motor_angle(log.q)
    error_rate = rate - robot.drive.motor_angle(log.dq)
    steps = 0.5 * log.dt * (error[1:] + error[:-1])
    integral = np.concatenate([np.zeros_like(error[:1]), np.cumsum(steps, axis=0)])
    return servo_torque(robot.servo, error, error_rate, integral).u_fb


def state_of(log: Log, machine: Machine, bristles: Bristles) -> State:
    """States along the measured motion, before anything is known of springs and loads."""
    robot, none = machine.physical, np.zeros_like(log.q)
    drive, friction = robot.drive, robot.friction
    stiff = np.where(drive.is_rigid, 0.0, drive.joint_stiffness)
    return State(
        time=log.t[:, None, None],
        motor_angle=drive.motor_angle(log.q),
        motor_speed=drive.motor_angle(log.dq),
        joint_angle=log.q,
        joint_speed=log.dq,
        deflection=none,
        deflection_rate=none,
        load=none,
        load_at_motor=none,
        joint_stiffness=stiff,
        joint_damping=np.where(drive.is_rigid, 0.0, drive.joint_damping),
        friction_sign=bristles.sign,
        coulomb=friction.coulomb,
        static=friction.static,
        viscous=friction.viscous,
        stribeck_velocity=friction.stribeck_velocity,
        feedback_torque=none if log.feedback is None else log.feedback,
        motor_torque=none,
        peak_torque=drive.peak_torque,
        temperature=_temperature(log, machine),
        running=_running(log, machine),
    )


def bent_state(state: State, bent: Deflection, robot: RobotDescription) -> State:
    """States with the deflections of the joints, and what their springs alone carry."""
    load = -(state.joint_stiffness * bent.angle + state.joint_damping * bent.rate)
    return replace(
        state,
        deflection=bent.angle,
        deflection_rate=bent.rate,
        load=load,
        load_at_motor=robot.drive.motor_torque(load),
    )


def loaded_state(state: State, added: Torques, robot: RobotDescription) -> State:
    """States whose load has what effects add to the springs."""
    if added.spring is None:
        return state
    load = state.load + added.spring
    return replace(state, load=load, load_at_motor=robot.drive.motor_torque(load))


def summed(effects: list[TorqueEffect], state: State, dt: float) -> Torques:
    """Torques of several effects together; each of them sees the load of the springs alone."""
    total = Torques()
    for effect in effects:
        added = torques_along(effect, state, dt)
        total.motor, total.spring, total.link = (
            _plus(total.motor, added.motor),
            _plus(total.spring, added.spring),
            _plus(total.link, added.link),
        )
    return total


def _plus(total: Array | None, more: Array | None) -> Array | None:
    if more is None:
        return total
    return more if total is None else total + more


def _in_order(machine: Machine) -> list[TorqueEffect]:
    """Motor-side torque effects, those that act on what the drive commands last: they see all that it must give."""
    return sorted(
        (e for e in machine.torque_effects if e.side == "motor"), key=lambda e: (e.code.startswith("M"), e.name)
    )


def _truly(log: Log, machine: Machine) -> Log:
    """The log with the motion that the motors made where resolvers err; the error hardly changes over itself."""
    if not machine.resolver_effects:
        return log
    drive = machine.physical.drive
    angle = drive.motor_angle(log.q)
    read, _ = machine.read_by_resolver(angle, drive.motor_angle(log.dq))
    q = log.q - drive.joint_angle(read - angle)
    dq = np.gradient(q, log.dt, axis=0)
    slip = log.slip_dq + np.where(log.slip_dq != 0, dq - log.dq, 0.0)
    return replace(log, q=q, dq=dq, ddq=np.gradient(dq, log.dt, axis=0), slip_dq=slip)


def _links(log: Log, robot: RobotDescription) -> tuple[LinkTerms, Array]:
    """Terms of the links where they hang in their springs, and the deflection at the first sample."""
    elastic = ~robot.drive.is_rigid
    bent = np.zeros_like(log.q)
    links = link_terms(robot, log.q, log.dq, log.dt)
    for _ in range(_PASSES - 1 if elastic.any() else 0):
        bent[..., elastic] = -links.torque(log.ddq)[..., elastic] / robot.drive.joint_stiffness[elastic]
        links = link_terms(robot, log.q + bent, log.dq, log.dt)
    return links, bent[0]


def _flown(
    springs: Springs, state: State, effects: list[TorqueEffect], torque: Array, start: Array, dt: float
) -> Deflection:
    """Deflections with effects that depend on them, from the rest in which they balance the load."""
    each = list(samples(state))
    memories: list[Array] = []

    def at(k: int, angle: Array, rate: Array) -> State:
        now = each[k]
        now.deflection, now.deflection_rate = angle, rate
        now.load = -(now.joint_stiffness * angle + now.joint_damping * rate)
        return now

    def pull(angle: Array) -> Array:
        """What is left of the balance at rest; grows with the deflection."""
        now = at(0, angle, np.zeros_like(angle))
        return springs.finite_stiffness * angle - torque[0] - _behind(effects, now, dt)[0]

    rest = resting(pull, start)
    first = at(0, rest, np.zeros_like(rest))
    memories.extend(effect.initial_memory(first) for effect in effects)

    def push(k: int, angle: Array, rate: Array) -> Array:
        total, memories[:] = _behind(effects, at(k, angle, rate), dt, memories)
        return total

    return springs.pushed_by(torque, push, rest)


def _behind(
    effects: list[TorqueEffect], now: State, dt: float, memories: list[Array] | None = None
) -> tuple[Array, list[Array]]:
    """What effects add behind the gearbox, link side, and what they remember then; None is relaxed."""
    total, later = np.zeros_like(now.deflection), []
    for i, effect in enumerate(effects):
        added, memory = effect.torques(now, effect.initial_memory(now) if memories is None else memories[i], dt)
        later.append(memory)
        for part in (added.spring, added.link):
            total = total if part is None else total + part
    return total, later


def _running(log: Log, machine: Machine) -> Array:
    """Time since the machine was switched on, or its session began [s], (T, M, 1)."""
    before = 0.0 if machine.climate is None else machine.climate.running_since
    times: Array = before + log.started[:, None] + log.t[:, None, None]
    return times


def _temperature(log: Log, machine: Machine) -> Array:
    """[degC], (T, M, N): measured, else by the machine's climate, else that of its default."""
    if log.temperature is not None:
        return log.temperature
    climate, times = machine.climate or Climate(), log.t
    n = log.robot.n_joints
    if machine.climate is None:
        return climate.temperature(times, n)[:, None] + np.zeros((1, len(log.recordings), 1))
    return np.stack([climate.at(climate.running_since + s).temperature(times, n) for s in log.started], axis=1)
