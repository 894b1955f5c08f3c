"""States along measured motions as effects see them: friction of bristles, and joints that bend under effects."""

from dataclasses import dataclass, fields, replace

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.log import Log
from ffgym.diagnosis.replay.recursions import first_order
from ffgym.diagnosis.replay.springs import Deflection, Springs, between, resting, straight
from ffgym.effects import State, TorqueEffect, Torques
from ffgym.effects.along import samples, torques_along
from ffgym.effects.leads import Leads
from ffgym.robot import RobotDescription
from ffgym.robot.friction import LuGreParameters
from ffgym.simulation.plant import Climate, Machine


@dataclass(frozen=True, kw_only=True, eq=False)
class Bristles:
    """Friction of one model along motor speeds, motor side, shape (T, M, N)."""

    torque: Array
    """[N m], viscous part included; opposes the motion."""
    sign: Array
    """LuGre-smoothed sign of the motor speed s = sigma_0 z / g(v) [1]."""


def along_speed(friction: LuGreParameters, slip: Array, speed: Array, dt: float, load: float = 0.0) -> Bristles:
    """Friction of bristles along samples `dt` [s] apart, motor side.

    Between two samples the bristle equation is solved exactly for their mean speed; where the speed changes its sign,
    for the mean speed before that and then for the one after it. With the sum of both alone, bristles would still
    pull forwards at the first sample at which the motor is fast again, and their damping would be a peak of torque.

    Args:
        friction: model of all joints.
        slip: speed that moves the bristles [rad/s], shape (T, M, N).
        speed: speed of the motors, which viscous friction sees [rad/s].
        dt: sample time [s].
        load: of the bristles at the first sample, as a share of what tears them off; 0 is relaxed.
    """
    keep, gain = _bristle_factors(friction, slip, dt)
    start = load * friction.stribeck_level(0.0 * slip[0]) / friction.bristle_stiffness
    bristle = first_order(keep, gain, start)
    return Bristles(
        torque=friction.torque(bristle, slip) + friction.viscous * (speed - slip),
        sign=friction.bristle_stiffness * bristle / friction.stribeck_level(slip),
    )


def _bristle_factors(friction: LuGreParameters, slip: Array, dt: float) -> tuple[Array, Array]:
    """Factors (keep, gain) that lead bristles from each sample to the next, shape (T - 1, M, N)."""
    keep, gain = friction.exact_bristle_factors(0.5 * (slip[1:] + slip[:-1]), dt)
    turns = slip[1:] * slip[:-1] < 0.0
    rows = np.flatnonzero(turns.any(axis=(1, 2)))
    if len(rows):
        first, last, turns = slip[:-1][rows], slip[1:][rows], turns[rows]
        before = dt * np.divide(first, first - last, out=np.ones_like(first), where=turns)
        forth, forth_gain = friction.exact_bristle_factors(0.5 * np.where(turns, first, first + last), before)
        back, back_gain = friction.exact_bristle_factors(0.5 * last, dt - before)
        keep[rows], gain[rows] = forth * back, forth_gain * back + back_gain
    return keep, gain


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
        # time since the machine was switched on, or its session began [s]
        running=(0.0 if machine.climate is None else machine.climate.running_since)
        + log.started[:, None]
        + log.t[:, None, None],
    )


def bent_state(state: State, bent: Deflection, robot: RobotDescription) -> State:
    """States with the deflections of the joints, and what their springs alone carry."""
    load = -(state.joint_stiffness * bent.angle + state.joint_damping * bent.rate)
    return replace(
        state, deflection=bent.angle, deflection_rate=bent.rate, load=load, load_at_motor=robot.drive.motor_torque(load)
    )


def loaded_state(state: State, added: Torques, needed: Array, robot: RobotDescription) -> State:
    """States whose load has what effects add to the springs; that of rigid joints is what links need (T, M, N)."""
    rigid = robot.drive.is_rigid
    if added.spring is None and not rigid.any():
        return state
    load = state.load if added.spring is None else state.load + added.spring
    load = np.where(rigid, needed, load)
    return replace(state, load=load, load_at_motor=robot.drive.motor_torque(load))


def _temperature(log: Log, machine: Machine) -> Array:
    """[degC], (T, M, N): measured, else by the machine's climate, else that of its default."""
    if log.temperature is not None:
        return log.temperature
    climate, times = machine.climate or Climate(), log.t
    n = log.robot.n_joints
    if machine.climate is None:
        return climate.temperature(times, n)[:, None] + np.zeros((1, len(log.recordings), 1))
    return np.stack([climate.at(climate.running_since + s).temperature(times, n) for s in log.started], axis=1)


def arm_effects(machine: Machine) -> list[TorqueEffect]:
    """Effects that depend on how joints bend."""
    return [effect for effect in machine.torque_effects if effect.side == "link" and not effect.is_null]


def summed(effects: list[TorqueEffect], state: State, dt: float) -> Torques:
    """Torques of several effects together; each of them sees the load of the springs alone."""
    total, leads = Torques(), Leads(are_in_load=False)
    for effect in effects:
        added = torques_along(effect, state, dt)
        total.motor, total.spring, total.link = (
            plus(plus(total.motor, added.motor), leads.beside(effect, state, added.spring)),
            plus(total.spring, added.spring),
            plus(total.link, added.link),
        )
    return total


def plus(total: Array | None, more: Array | None) -> Array | None:
    """Sum of what there is; None is nothing."""
    if more is None:
        return total
    return more if total is None else total + more


def deflected(
    springs: Springs, state: State, effects: list[TorqueEffect], torque: Array, start: Array, dt: float
) -> Deflection:
    """Deflections under `torque` (T, M, N) and what effects add; sample by sample where that depends on them.

    The state is that where joints do not bend yet; about as `start` (M, N) [rad] they bend at the first sample.
    """
    led = summed([effect for effect in effects if effect.follows_motor], state, dt)
    load = torque if (push := plus(led.spring, led.link)) is None else torque + push
    bending = [effect for effect in effects if not effect.follows_motor]
    if bending:
        return flown(springs, state, bending, load, start, dt)
    bent = springs.bent_by(load[..., None])
    return Deflection(angle=bent.angle[..., 0], rate=bent.rate[..., 0], acceleration=bent.acceleration[..., 0])


def flown(
    springs: Springs, state: State, effects: list[TorqueEffect], torque: Array, start: Array, dt: float
) -> Deflection:
    """Deflections with effects that depend on them, from the rest in which they balance the load."""
    every = springs.substeps
    if every > 1:  # the state at so many steps in each sample, on straight lines
        n, finer = len(state.motor_angle), {}
        for name in (f.name for f in fields(State)):
            if len(values := getattr(state, name)) == n and values.ndim > 1:
                finer[name] = straight(values, every)
        state = replace(state, **finer)
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
        return springs.restoring(angle) - torque[0] - _behind(effects, now, dt)[0]

    rest = resting(pull, start)
    first = at(0, rest, np.zeros_like(rest))
    memories.extend(effect.initial_memory(first) for effect in effects)

    def push(k: int, angle: Array, rate: Array) -> Array:
        total, memories[:] = _behind(effects, at(k, angle, rate), dt / every, memories)
        return total

    if every == 1:
        return springs.pushed_by(torque, push, rest)
    return springs.finer.pushed_by(between(torque, every), push, rest).at_every(every)


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
