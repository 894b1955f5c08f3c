"""States where model feed-forward puts the arm, as its resolvers read them, and effects on the motors there."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ffgym.agents.flexible_joints import Lead
from ffgym.agents.model_memory import Carried, Start
from ffgym.core.types import Array
from ffgym.effects import State, TorqueEffect
from ffgym.effects.along import iterate_samples
from ffgym.effects.together import relax, sort_effects, step
from ffgym.simulation.plant import Machine

_MOTION = ("time", "joint_angle", "joint_speed", "deflection", "deflection_rate", "load", "command")
"""Variables of a state that a law gives; all others follow from them."""


def state_between(here: State, after: State, shares: Array) -> State:
    """Interpolate states at `shares` (S,) of the straight way from one to another, (S, ..., N) each."""
    across = shares.reshape(-1, *[1] * here.load.ndim)
    ends = {name: (getattr(here, name), getattr(after, name)) for name in _MOTION}
    return here.with_values(**{name: start + (end - start) * across for name, (start, end) in ends.items()})


_READING_ROUNDS = 20
"""Rounds of the search for the angle that a resolver reads as a given one, as in a plant."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ModelStates:
    """States of one machine at samples of a motion, (..., N) each."""

    machine: Machine

    @cached_property
    def _still(self) -> State:
        """State of the machine but for its motion."""
        robot = self.machine.physical
        none = np.zeros(robot.n_joints)
        return State.of(robot, self.machine.climate, bristle=none, feedback_torque=none)

    def reading_error(self, q: Array) -> Array:
        """Compute the error of the resolvers where the servo rests, as they read `q` there [rad], motor side."""
        still, motor_q = np.zeros_like(q), self.machine.physical.drive.motor_angle(q)
        error = still
        for _ in range(_READING_ROUNDS):
            error = self.machine.read_by_resolver(motor_q - error, still)[0] - (motor_q - error)
        return error

    def at(self, sample: tuple[Array, Array, Array], carried: Carried, lead: Lead, start: Start, time: Array) -> State:
        """Build the state at a sample; its command keeps motors and links there, but for friction and effects."""
        (q, motor_dq, motor_ddq), drive = sample, self.machine.physical.drive
        rotor = drive.rotor_inertia * (motor_ddq + drive.motor_angle(lead.acceleration))
        return self._still.with_values(
            time=time,
            joint_angle=q + lead.angle - drive.joint_angle(start.error),
            joint_speed=drive.joint_angle(motor_dq) + lead.speed,
            command=drive.motor_torque(carried.load) + rotor - carried.reaction,
            deflection=-(lead.angle + start.bend / drive.joint_stiffness),
            deflection_rate=-lead.speed,
            load=carried.load,
        )

    def seen(self, state: State, lead: Lead, start: Start) -> Lead:
        """Compute the lead as the resolver shows it to the servo."""
        drive, angle, speed = self.machine.physical.drive, state.motor_angle, state.motor_speed
        read_angle, read_speed = self.machine.read_by_resolver(angle, speed)
        return Lead(
            angle=lead.angle + drive.joint_angle(read_angle - angle - start.error),
            speed=lead.speed + drive.joint_angle(read_speed - speed),
            acceleration=lead.acceleration,
        )


ROUNDS = 5
"""Rounds of the search for the command whose effects are a share of it: 0.1 to this power is negligible."""


@dataclass(frozen=True, kw_only=True, eq=False)
class MotorEffects:
    """Effects that act on the motors alone, of one machine."""

    machine: Machine

    @cached_property
    def effects(self) -> tuple[TorqueEffect, ...]:
        """Effects on the motors of the machine, in a fixed order."""
        known = self.machine.torque_effects_without_engine
        return tuple(sort_effects(effect for effect in known if effect.side != "link"))

    def rest(self, state: State) -> tuple[Array, list[Array]]:
        """Find the torque of effects on motors that rest [N m], (..., N), and their memories there."""
        needed, added, memories = state.command, np.zeros_like(state.load), list[Array]()
        for _ in range(ROUNDS + 1):
            state = state.with_values(command=needed - added)
            memories = relax(self.effects, state)
            added = self._sum_torques(self.effects, state, memories, 1.0)[0]
        return added, memories

    def within(self, states: State, friction: Array, memories: Sequence[Array], dt: float) -> tuple[Array, list[Array]]:
        """Compute torque of effects within a control step [N m], motor side, (S, ..., N), and their memories after it.

        Args:
            states: states in the middle of S sub-steps, (S, ..., N); commands are without friction and effects.
            friction: LuGre friction there [N m], (S, ..., N).
            memories: memories before the step, (..., N, M) each.
            dt: length of the step [s].
        """
        needed = states.command + friction
        if not self.effects:
            return np.zeros_like(needed), []
        states.set_values(command=needed)
        # effects with memory, sub-step by sub-step
        later = list(memories)
        lasting = [k for k, memory in enumerate(memories) if memory.shape[-1]]
        torques = []
        for state in iterate_samples(states) if lasting else ():
            ones = [self.effects[k] for k in lasting]
            torque, after = self._sum_torques(ones, state, [later[k] for k in lasting], dt / len(needed))
            torques.append(torque)
            for k, memory in zip(lasting, after, strict=True):
                later[k] = memory
        # torque of effects with memory, fixed from here on
        added = np.stack(torques) if torques else np.zeros_like(needed)
        # the others at once: their torque under the command that balances it, by fixed-point rounds
        others = [k for k in range(len(memories)) if k not in lasting]
        needed, at_once = needed - added, np.zeros_like(needed)
        for _ in range(ROUNDS):
            states.set_values(command=needed - at_once)
            before = at_once
            at_once, _ = self._sum_torques(
                [self.effects[k] for k in others], states, [memories[k] for k in others], 1.0
            )
            if np.array_equal(before, at_once):  # further rounds change no bit
                break
        return added + at_once, later

    def _sum_torques(
        self, effects: Sequence[TorqueEffect], state: State, memories: Sequence[Array], dt: float
    ) -> tuple[Array, list[Array]]:
        """Sum the torque on the motors, motor side [N m], and advance memories by `dt` [s]."""
        added, later = step(effects, state, memories, dt)
        return np.zeros_like(state.load) if added.motor is None else added.motor, later
