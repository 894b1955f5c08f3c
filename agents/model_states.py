"""Effects on the motors in model feed-forward, and the states that effects are asked at: where a law puts the arm."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np

from ffgym.core.types import Array
from ffgym.effects import State, TorqueEffect
from ffgym.effects.along import samples
from ffgym.simulation.plant import Climate, Machine

AMBIENT = Climate()
"""What effects see of a machine whose climate nobody knows."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Place:
    """Where motors and links are at a sample, and what moves them there; (..., N) each."""

    time: Array
    """Since the motion began [s]."""
    joint_angle: Array
    """Gearbox output, link side [rad]."""
    joint_speed: Array
    """[rad/s], link side."""
    deflection: Array
    """Link behind gearbox output [rad], link side."""
    deflection_rate: Array
    """[rad/s], link side."""
    load: Array
    """Torque that the gearbox passes on to the link [N m], link side."""
    needed: Array
    """Torque that the motor must give, but for friction and effects, gravity included [N m], motor side."""

    def towards(self, other: "Place", shares: Array) -> "Place":
        """Places at `shares` (S,) of the straight way to another one, (S, ..., N) each."""
        across = shares.reshape(-1, *[1] * self.load.ndim)

        def between(name: str) -> Array:
            start: Array = getattr(self, name)
            end: Array = getattr(other, name)
            return start + (end - start) * across

        return Place(**{f.name: between(f.name) for f in fields(self)})


def state_at(machine: Machine, place: Place, *, bristle: Array, command: Array) -> State:
    """State that effects of a machine are asked at.

    Args:
        machine: what the law believes.
        place: where motors and links are, (..., N).
        bristle: deflection of the LuGre bristles [rad], (..., N).
        command: torque that the servo commands [N m], motor side, (..., N).
    """
    drive, friction = machine.physical.drive, machine.physical.friction
    speed, climate = drive.motor_angle(place.joint_speed), machine.climate or AMBIENT
    times = place.time[..., 0].reshape(-1)  # the same for all joints
    return State(
        time=place.time,
        running=climate.running_since + place.time,
        motor_angle=drive.motor_angle(place.joint_angle),
        motor_speed=speed,
        joint_angle=place.joint_angle,
        joint_speed=place.joint_speed,
        deflection=place.deflection,
        deflection_rate=place.deflection_rate,
        load=place.load,
        load_at_motor=drive.motor_torque(place.load),
        joint_stiffness=np.where(drive.is_rigid, 0.0, drive.joint_stiffness),
        joint_damping=np.where(drive.is_rigid, 0.0, drive.joint_damping),
        friction_sign=friction.bristle_stiffness * bristle / friction.stribeck_level(speed),
        coulomb=friction.coulomb,
        static=friction.static,
        viscous=friction.viscous,
        stribeck_velocity=friction.stribeck_velocity,
        feedback_torque=np.zeros_like(command),
        motor_torque=_limited(machine, command),
        peak_torque=drive.peak_torque,
        temperature=climate.temperature(times, machine.robot.n_joints).reshape(place.time.shape),
    )


def _limited(machine: Machine, command: Array) -> Array:
    """What drives give of a command [N m], motor side."""
    peak = machine.physical.drive.peak_torque
    return np.minimum(np.maximum(command, -peak), peak)


ROUNDS = 5
"""Of the search for the command whose effects are a share of it: 0.1 to this power is below what matters."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Motors:
    """Effects that act on the motors alone, of one machine."""

    machine: Machine

    @cached_property
    def effects(self) -> tuple[TorqueEffect, ...]:
        """Those of the machine, in a fixed order."""
        chosen = [effect for effect in self.machine.torque_effects if effect.side != "link"]
        return tuple(sorted(chosen, key=lambda effect: effect.name))

    def rest(self, place: Place) -> tuple[Array, list[Array]]:
        """What effects add to motors at rest [N m], (..., N), and what they remember there."""
        none, added = np.zeros_like(place.load), np.zeros_like(place.load)
        memories: list[Array] = []
        for _ in range(ROUNDS + 1):
            state = state_at(self.machine, place, bristle=none, command=place.needed - added)
            memories = [effect.initial_memory(state) for effect in self.effects]
            added = none
            for effect, memory in zip(self.effects, memories, strict=True):
                added = _with(added, effect.torques(state, memory, 1.0)[0].motor)
        return added, memories

    def within(
        self, between: Place, bristles: Array, friction: Array, memories: Sequence[Array], dt: float
    ) -> tuple[Array, list[Array]]:
        """What effects add within a control step [N m], motor side, (S, ..., N), and what they remember after it.

        Args:
            between: where motors and links are in the middle of S sub-steps, (S, ..., N).
            bristles: deflection of the bristles there [rad], (S, ..., N).
            friction: LuGre friction there [N m], (S, ..., N).
            memories: what effects remember before, (..., N, M) each.
            dt: length of the step [s].
        """
        needed = between.needed + friction
        added, later = np.zeros_like(needed), list[Array]()
        if not self.effects:
            return added, later
        states = state_at(self.machine, between, bristle=bristles, command=needed)
        # effects with memory, sub-step by sub-step
        for effect, memory in zip(self.effects, memories, strict=True):
            after = memory
            if memory.shape[-1]:
                torques = []
                for state in samples(states):
                    torque, after = effect.torques(state, after, dt / len(needed))
                    torques.append(np.zeros_like(state.load) if torque.motor is None else torque.motor)
                added = added + np.stack(torques)
            later.append(after)
        # the others at once: what they add to a command that gives what is needed with them
        needed, at_once = needed - added, np.zeros_like(needed)
        for _ in range(ROUNDS):
            states.motor_torque = _limited(self.machine, needed - at_once)
            before, at_once = at_once, np.zeros_like(needed)
            for effect, memory in zip(self.effects, memories, strict=True):
                if not memory.shape[-1]:
                    at_once = _with(at_once, effect.torques(states, memory, 1.0)[0].motor)
            if np.array_equal(before, at_once):  # further rounds change no bit
                break
        return added + at_once, later


def _with(total: Array, more: Array | None) -> Array:
    return total if more is None else total + more
