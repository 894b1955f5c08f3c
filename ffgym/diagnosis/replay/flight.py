"""Joints that bend under effects which depend on how they bend."""

from dataclasses import fields, replace

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.replay.springs import Deflection, Springs, between, resting, straight
from ffgym.effects import State, TorqueEffect, Torques
from ffgym.effects.along import samples, torques_along
from ffgym.effects.leads import Leads
from ffgym.simulation.plant import Machine


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

    Args:
        springs: of the joints.
        state: along the measured motion, where joints do not bend yet.
        effects: that act behind the gearboxes.
        torque: on the links, link side [N m].
        start: about how the joints bend at the first sample, (M, N).
        dt: sample time [s].

    Raises:
        FlownAwayError: if an effect pushes the arm away from its springs.
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
    each = list(samples(state if every == 1 else _finer(state, every)))
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


def _finer(state: State, every: int) -> State:
    """The state at so many steps in each sample, on straight lines."""
    n = len(state.motor_angle)
    moving = {f.name: values for f in fields(State) if len(values := getattr(state, f.name)) == n and values.ndim > 1}
    return replace(state, **{name: straight(values, every) for name, values in moving.items()})


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
