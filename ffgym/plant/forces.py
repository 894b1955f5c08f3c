"""Effects that MuJoCo does not have, as torques at every physics step: the one extension point of the plant.

Nothing here runs while no machine of the batch has such an effect.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from mujoco import batch

from ffgym.effects import ResolverEffect, ResolverError, State, Torques
from ffgym.effects.stack import by_kind, stacked
from ffgym.plant.addresses import Addresses
from ffgym.plant.machine import Machine
from ffgym.plant.numbers import Numbers
from ffgym.types import Array, BoolArray, IntArray


class Forces:
    """Torque and resolver effects of B machines, one row each, with what they remember."""

    def __init__(self, engine: batch.Batch, at: Addresses, machines: Sequence[Machine]) -> None:
        self._engine, self._at = engine, at
        self._drive = machines[0].robot.drive
        self._dt = float(engine.get_model(0).opt.timestep)
        self._n = n = machines[0].robot.n_joints
        self._qpos, self._qvel, self._act = (engine.bind(name) for name in ("qpos", "qvel", "act"))
        self._time, self._controls, self._applied = (engine.bind(name) for name in ("time", "ctrl", "qfrc_applied"))
        self._numbers = Numbers.of(machines, n)
        self._torque = [
            (stacked(kind, members, n), np.array([m is not None for m in members]))
            for kind, members in by_kind([machine.torque_effects for machine in machines])
        ]
        self._resolver = [
            stacked(kind, members, n) for kind, members in by_kind([machine.resolver_effects for machine in machines])
        ]
        self._memory: list[Array] = []
        self._memory = [effect.initial_memory(self.state(slice(None))) for effect, _ in self._torque]

    @staticmethod
    def needed(machines: Sequence[Machine]) -> bool:
        """Whether any machine has an effect that acts here."""
        return any(machine.torque_effects or machine.resolver_effects for machine in machines)

    def begin(self, rows: IntArray, state: State) -> None:
        """Forget what was: simulations `rows` (B',) are at rest in `state`."""
        for (effect, _), memory in zip(self._torque, self._memory, strict=True):
            memory[rows] = _rows_of(effect, rows).initial_memory(state)

    def resting(self, state: State, rows: IntArray) -> Torques:
        """What is added to robots `rows` that rest in `state`, with memories that are relaxed there."""
        members = [_rows_of(effect, rows) for effect, _ in self._torque]
        return self._sum(state, rows, [effect.initial_memory(state) for effect in members], self._dt)

    @property
    def bends(self) -> BoolArray:
        """Which simulations have something that acts on springs or links, shape (B,)."""
        bends = np.zeros(self._engine.nsim, dtype=np.bool_)
        for effect, present in self._torque:
            if effect.side == "link":
                bends |= present
        return bends

    def resolver_error(self, motor_angle: Array, motor_speed: Array) -> ResolverError:
        """What resolvers read beyond the true angle [rad] and speed [rad/s], motor side, (B, N) each."""
        return _resolver_error(self._resolver, motor_angle, motor_speed)

    def apply(self, rows: IntArray | slice, dt: float) -> None:
        """Set the engine's applied torques and resolver readings for the physics step of `dt` [s] that comes next."""
        n = self._n
        if self._resolver:
            motor_q, motor_dq = self._motor(rows)
            error = _resolver_error([_rows_of(e, rows) for e in self._resolver], motor_q, motor_dq)
            self._controls[rows, 0 : 3 * n : 3] -= error.angle
            self._controls[rows, 1 : 3 * n : 3] -= error.speed
        if self._torque:
            self._apply_torques(rows, dt)

    def _apply_torques(self, rows: IntArray | slice, dt: float) -> None:
        memories = [memory[rows] for memory in self._memory]
        total = self._sum(self.state(rows), rows, memories, dt)
        for mine, later in zip(self._memory, memories, strict=True):
            mine[rows] = later
        self._write(rows, total)

    def _sum(self, state: State, rows: IntArray | slice, memories: list[Array], dt: float) -> Torques:
        """All torques together; `memories` are replaced by those after `dt` [s]."""
        motor, link, spring = np.zeros_like(state.load), np.zeros_like(state.load), np.zeros_like(state.load)
        alone = state.load, state.load_at_motor
        for k, (effect, present) in enumerate(self._torque):
            added, memories[k] = _rows_of(effect, rows).torques(state, memories[k], dt)
            here = present[rows, None]  # a machine without the effect is not touched, whatever rounding does
            if added.spring is not None:
                spring += np.where(here, added.spring, 0.0)
                state.load = state.load + np.where(here, added.spring, 0.0)
                state.load_at_motor = self._drive.motor_torque(state.load)
            if added.motor is not None:
                motor += np.where(here, added.motor, 0.0)
            if added.link is not None:
                link += np.where(here, added.link, 0.0)
        state.load, state.load_at_motor = alone
        return Torques(motor=motor, spring=spring, link=link)

    def _write(self, rows: IntArray | slice, total: Torques) -> None:
        """Generalised forces: motor hinges turn rotor and link, deflection hinges the link alone."""
        at = self._at
        assert total.motor is not None
        assert total.link is not None
        assert total.spring is not None
        everyone = np.arange(self._engine.nsim)[rows]
        self._applied[np.ix_(everyone, at.motor_qpos)] = self._drive.joint_torque(total.motor) + total.link
        behind = (total.spring + total.link)[:, at.is_elastic]
        self._applied[np.ix_(everyone, at.deflection_qpos)] = behind

    def state(self, rows: IntArray | slice) -> State:
        """State of simulations `rows` now, (B', N) each."""
        at, drive, own = self._at, self._drive, self._numbers.rows(rows)
        qpos, qvel = self._qpos[rows], self._qvel[rows]
        joint_q, joint_dq = qpos[:, at.motor_qpos], qvel[:, at.motor_qpos]
        motor_q, motor_dq = drive.motor_angle(joint_q), drive.motor_angle(joint_dq)
        deflection, rate = np.zeros_like(joint_q), np.zeros_like(joint_q)
        deflection[:, at.is_elastic] = qpos[:, at.deflection_qpos]
        rate[:, at.is_elastic] = qvel[:, at.deflection_qpos]
        feedback, command = self._servo(rows, motor_q, motor_dq, own)
        time = self._time[rows].reshape(-1, 1)
        load = -(own.stiffness * deflection + own.damping * rate)
        return State(
            time=time,
            motor_angle=motor_q,
            motor_speed=motor_dq,
            joint_angle=joint_q,
            joint_speed=joint_dq,
            deflection=deflection,
            deflection_rate=rate,
            load=load,
            load_at_motor=drive.motor_torque(load),
            joint_stiffness=own.stiffness,
            joint_damping=own.damping,
            friction_sign=self._friction_sign(rows, motor_dq, own),
            coulomb=own.coulomb,
            static=own.static,
            viscous=own.viscous,
            stribeck_velocity=own.stribeck_velocity,
            feedback_torque=feedback,
            motor_torque=command,
            peak_torque=own.peak_torque,
            temperature=own.temperature(time),
        )

    def _motor(self, rows: IntArray | slice) -> tuple[Array, Array]:
        """Motor angles [rad] and speeds [rad/s], motor side."""
        at, drive = self._at, self._drive
        return (
            drive.motor_angle(self._qpos[rows][:, at.motor_qpos]),
            drive.motor_angle(self._qvel[rows][:, at.motor_qpos]),
        )

    def _servo(self, rows: IntArray | slice, angle: Array, speed: Array, own: Numbers) -> tuple[Array, Array]:
        """What MuJoCo's `pid` computes in the coming step: feedback and limited total, motor side [N m]."""
        controls = self._controls[rows]
        n = self._n
        integral = np.zeros_like(angle)
        at = self._at
        integral[:, at.has_integral] = self._act[rows][:, at.integral[at.has_integral]]
        feedback = (
            own.position_gain * (controls[:, 0 : 3 * n : 3] - angle)
            + own.velocity_gain * (controls[:, 1 : 3 * n : 3] - speed)
            + own.integral_gain * integral
        )
        total = feedback + controls[:, 2 : 3 * n : 3]
        return feedback, np.minimum(np.maximum(total, -own.peak_torque), own.peak_torque)

    def _friction_sign(self, rows: IntArray | slice, speed: Array, own: Numbers) -> Array:
        at = self._at
        bristle = np.zeros_like(speed)
        bristle[:, at.has_bristle] = self._act[rows][:, at.bristle[at.has_bristle]]
        level = own.coulomb + (own.static - own.coulomb) * np.exp(-((speed / own.stribeck_velocity) ** 2))
        return own.bristle_stiffness * bristle / level


def _resolver_error(effects: Sequence[ResolverEffect], motor_angle: Array, motor_speed: Array) -> ResolverError:
    """All errors of the position sensors together, one after the other as in `Machine.read_by_resolver`."""
    angle, speed = motor_angle, motor_speed
    for effect in effects:
        error = effect.error(angle, speed)
        angle, speed = angle + error.angle, speed + error.speed
    return ResolverError(angle=angle - motor_angle, speed=speed - motor_speed)


def _rows_of(effect: Any, rows: IntArray | slice) -> Any:
    """The stacked effect for some of the machines."""
    if isinstance(rows, slice):
        return effect
    some = object.__new__(type(effect))
    for name, value in effect.values().items():
        object.__setattr__(some, name, value[rows])
    return some
