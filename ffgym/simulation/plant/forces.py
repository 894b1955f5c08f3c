"""Effects that MuJoCo does not have, as torques at every physics step: the one extension point of the plant.

Nothing here runs while no machine of the batch has such an effect.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from mujoco import batch

from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.effects import ResolverEffect, ResolverError, State, TorqueEffect, Torques
from ffgym.effects.stack import by_kind, stack_effects
from ffgym.effects.together import relax, step
from ffgym.robot.drive import loop_decay
from ffgym.simulation.plant.compiled.code import can_compile
from ffgym.simulation.plant.compiled.engine_hook import is_free
from ffgym.simulation.plant.compiled.formulas import Layout, untraceable_kinds
from ffgym.simulation.plant.compiled.step import CompiledStep
from ffgym.simulation.plant.engine_state import Addresses, hinge_torques
from ffgym.simulation.plant.machine import Machine
from ffgym.simulation.plant.reading import EngineState, Reading, stack_numbers
from ffgym.simulation.plant.resolvers import Resolvers, read_beyond, sum_errors

READING = "reading"
"""Name of the motor angles and speeds that servos know, beside the names of MuJoCo's arrays."""

_ROUNDS = 20
"""Rounds of the search for the angle that a resolver reads as a given one; errors change by less than 0.1 of the
angle."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Chosen:
    """Some simulations of a batch with their effects, looked up once for many physics steps."""

    rows: IntArray | slice
    """Indices of the simulations; a slice stands for all."""
    everyone: IntArray
    """Indices as a column, shape (B', 1)."""
    numbers: dict[str, Array]
    torque: tuple[TorqueEffect, ...]
    present: tuple[BoolArray | None, ...]
    """Mask of machines that have each effect, shape (B', 1); None stands for all."""
    resolver: tuple[ResolverEffect, ...]

    @property
    def on_links(self) -> "Chosen":
        """The same simulations with the effects on springs and links alone."""
        torque = [
            (effect, have) for effect, have in zip(self.torque, self.present, strict=True) if effect.side == "link"
        ]
        return replace(self, torque=tuple(effect for effect, _ in torque), present=tuple(have for _, have in torque))


class Forces:
    """Torque and resolver effects of B machines, one row each, with their memories."""

    def __init__(self, engine: batch.Batch, at: Addresses, machines: Sequence[Machine]) -> None:
        self._engine, self._at, self._n_robots = engine, at, len(machines)
        self._drive = machines[0].robot.drive
        self._dt = float(engine.get_model(0).opt.timestep)
        self._n = n = machines[0].robot.n_joints
        self._engine_state = EngineState(engine, at, self._drive)
        self._controls, self._applied = engine.bind("ctrl"), engine.bind("qfrc_applied")
        # effects of all robots, one stack of each kind, for computing them together
        self._numbers = numbers = stack_numbers(machines)
        numbers["loop_decay"] = loop_decay(numbers["loop_lag"], self._dt)
        numbers["loop_most"] = numbers["loop_rate"] * self._dt
        self._torque = [
            (stack_effects(kind, members, n), np.array([m is not None for m in members]))
            for kind, members in by_kind([machine.torque_effects for machine in machines])
        ]
        self._resolver = [
            (stack_effects(kind, members, n), np.array([m is not None for m in members]))
            for kind, members in by_kind([machine.resolver_effects for machine in machines])
        ]
        robots = [machine.physical for machine in machines]
        reads = any(robot.drive.resolver_period > 0 for robot in robots)
        self._readings = Resolvers(robots, self._dt) if reads else None
        self._keys: list[tuple[type[TorqueEffect], int]] = []  # each kind, and how many of it came before
        for effect, _ in self._torque:
            kind = type(effect)
            self._keys.append((kind, sum(known is kind for known, _ in self._keys)))
        self._motor = np.zeros((self._n_robots, n))  # what effects added to motors last, link side
        for effect, _ in self._torque:
            effect.check_step(self._dt)
        # memory of the effects at rest
        self._everyone = self.choose(slice(None))
        state = self.state(self._everyone)
        shapes = (self._n_robots, n)
        self._memory = [
            np.array(np.broadcast_to(memory, (*shapes, memory.shape[-1])), dtype=np.float64, order="C")
            for memory in relax(self._everyone.torque, state)
        ]

    @staticmethod
    def needed(machines: Sequence[Machine]) -> bool:
        """True if any machine has a torque or resolver effect, or a servo that reads resolvers."""
        return any(
            machine.torque_effects or machine.resolver_effects or machine.physical.drive.resolver_period > 0
            for machine in machines
        )

    def choose(self, rows: IntArray | slice) -> Chosen:
        """Simulations `rows` with their effects."""
        return Chosen(
            rows=rows,
            everyone=np.arange(self._n_robots)[rows][:, None],
            numbers={name: values[rows] for name, values in self._numbers.items()},
            torque=tuple(_rows_of(effect, rows) for effect, _ in self._torque),
            present=tuple(None if have.all() else have[rows, None] for _, have in self._torque),
            resolver=tuple(_rows_of(effect, rows) for effect, _ in self._resolver),
        )

    @property
    def bends(self) -> BoolArray:
        """Mask of simulations with effects on springs or links, shape (B,)."""
        bends = np.zeros(self._n_robots, dtype=np.bool_)
        for effect, present in self._torque:
            if effect.side == "link":
                bends |= present
        return bends

    def read_as(self, chosen: Chosen, joint_q: Array) -> Array:
        """Joint positions [rad] at which resolvers read `joint_q`, where a servo has come to rest; (B', N)."""
        wanted, shift = self._drive.motor_angle(joint_q), np.zeros_like(joint_q)
        for _ in range(_ROUNDS if chosen.resolver else 0):
            shift = sum_errors(chosen.resolver, wanted - shift, np.zeros_like(wanted)).angle
        return joint_q - self._drive.joint_angle(shift)

    def begin(self, chosen: Chosen, state: State) -> None:
        """Reset memories: simulations are at rest in `state`."""
        self._motor[chosen.rows] = 0.0
        if self._readings is not None:
            self._readings.begin(chosen.rows, *self._sense(chosen, *self._engine_state.motor(chosen.rows)))
        for memory, now in zip(self._memory, relax(chosen.torque, state), strict=True):
            memory[chosen.rows] = now

    def copy_memories(self) -> list[Array]:
        """Copies of the memories of effects, of the torques that they added to motors last, and of readings."""
        return [memory.copy() for memory in self._memories]

    def remember(self, memories: list[Array]) -> None:
        """Restore `remembered` memories and torques."""
        for memory, kept in zip(self._memories, memories, strict=True):
            memory[:] = kept

    @property
    def _memories(self) -> tuple[Array, ...]:
        return (*self._memory, self._motor, *(() if self._readings is None else self._readings.memory))

    def go_on_from(self, before: "Forces", rows: IntArray) -> None:
        """Take over memories of `before` in simulations `rows`, whose machines are unchanged."""
        self._motor[rows] = before._motor[rows]
        if self._readings is not None and before._readings is not None:
            for memory, kept in zip(self._readings.memory, before._readings.memory, strict=True):
                memory[rows] = kept[rows]
        known = dict(zip(before._keys, before._memory, strict=True))
        for key, memory in zip(self._keys, self._memory, strict=True):
            if key in known:
                memory[rows] = known[key][rows]

    def resting(self, chosen: Chosen, state: State) -> Torques:
        """Compute torques added to robots that rest in `state`, with relaxed memories."""
        return step(chosen.torque, state, relax(chosen.torque, state), self._dt, chosen.present)[0]

    def resolver_error(self, motor_angle: Array, motor_speed: Array) -> ResolverError:
        """Compute errors of what servos know, in angle [rad] and speed [rad/s], motor side, (B, N) each."""
        return self._error(self._everyone, motor_angle, motor_speed)

    @property
    def has_readings(self) -> bool:
        """True if the servos of any simulation read resolvers."""
        return self._readings is not None

    def reading(self, chosen: Chosen | None = None) -> Array:
        """Motor angles [rad], then speeds [rad/s], as servos know them now, motor side, (B', 2 N); None is all."""
        chosen = chosen or self._everyone
        angle, speed = self._engine_state.motor(chosen.rows)
        error = self._error(chosen, angle, speed)
        return np.concatenate([angle + error.angle, speed + error.speed], axis=1)

    def _sense(self, chosen: Chosen, angle: Array, speed: Array) -> tuple[Array, Array]:
        """Motor angles [rad] and speeds [rad/s] that resolvers see, with their errors, (B', N) each."""
        if chosen.resolver:
            error = sum_errors(chosen.resolver, angle, speed)
            angle, speed = angle + error.angle, speed + error.speed
        return angle, speed

    def _error(self, chosen: Chosen, angle: Array, speed: Array) -> ResolverError:
        """Compute what servos know beyond true motor angles [rad] and speeds [rad/s], (B', N) each."""
        if self._readings is None:
            return sum_errors(chosen.resolver, angle, speed)
        read = self._readings.read(chosen.rows)
        if self._readings.all_present:
            return ResolverError(angle=read[0] - angle, speed=read[1] - speed)
        # those that read nothing keep their bits
        error = sum_errors(chosen.resolver, angle, speed)
        return read_beyond(read, angle, speed, error, self._readings.present[chosen.rows])

    def state(self, chosen: Chosen) -> State:
        """State of simulations now, (B', N) each."""
        return Reading(self._engine_state, chosen.rows, chosen.numbers, self._motor[chosen.rows])

    def rollout(
        self, engine: batch.Batch, controls: Array, record: tuple[str, ...], ids: IntArray | None
    ) -> dict[str, Array]:
        """Roll out `controls` (B, S, 3 N) as the engine does, with torques of effects in each physics step."""
        compiled, by_numpy = self._compiled
        odd = by_numpy if ids is None else by_numpy[ids]
        if compiled is None or odd.all() or not is_free():
            return self._rollout_by_numpy(engine, controls, record, ids)
        if not odd.any():
            return self._rollout_compiled(compiled, controls, record, ids)
        # machines with an effect that has no code run apart, so that the others keep their bits
        rows = np.arange(self._n_robots) if ids is None else ids
        parts = {
            True: self._rollout_by_numpy(engine, controls[odd], record, rows[odd]),
            False: self._rollout_compiled(compiled, controls[~odd], record, rows[~odd]),
        }
        out = {name: np.empty((*controls.shape[:2], *parts[True][name].shape[2:])) for name in record}
        for is_odd, part in parts.items():
            for name, values in part.items():
                out[name][odd == is_odd] = values
        return out

    @cached_property
    def _compiled(self) -> tuple[CompiledStep | None, BoolArray]:
        """Physics step as compiled code, None without, and the mask (B,) of machines that numpy must compute."""
        everything = np.ones(self._n_robots, dtype=np.bool_)
        layout = self._layout()
        odd = untraceable_kinds(layout) if can_compile() else None
        if odd is None:
            return None, everything
        by_numpy = np.zeros(self._n_robots, dtype=np.bool_)
        for effect, have in (*self._torque, *self._resolver):
            by_numpy |= have & (type(effect) in odd)
        if by_numpy.all():
            return None, everything
        # numbers and memories of those that have code, in their order
        numbers: dict[Any, Array] = {("machine", name): values for name, values in self._numbers.items()}
        torque = [(effect, have, memory) for (effect, have), memory in zip(self._torque, self._memory, strict=True)]
        torque = [each for each in torque if type(each[0]) not in odd]
        for k, (effect, have, _) in enumerate(torque):
            numbers |= {("effect", k, name): values for name, values in effect.values().items()}
            numbers["present", k] = have[:, None].astype(np.float64)
        resolver = [effect for effect, _ in self._resolver if type(effect) not in odd]
        for k, error in enumerate(resolver):
            numbers |= {("resolver effect", k, name): values for name, values in error.values().items()}
        readings = () if self._readings is None else self._readings.memory
        if self._readings is not None:
            numbers |= {("resolver", name): values for name, values in self._readings.numbers.items()}
        layout = replace(
            layout,
            kinds=tuple(each for each in layout.kinds if each[0] not in odd),
            resolver_kinds=tuple(type(effect) for effect in resolver),
        )
        memories = [*(memory for _, _, memory in torque), self._motor, *readings]
        return CompiledStep(self._engine, layout, numbers, memories, self._engine_state.outputs), by_numpy

    def _layout(self) -> Layout:
        """Structure of all simulations."""
        memories = zip(self._torque, self._memory, strict=True)
        return Layout(
            kinds=tuple((type(effect), memory.shape[-1]) for (effect, _), memory in memories),
            resolver_kinds=tuple(type(effect) for effect, _ in self._resolver),
            reads=self._readings is not None,
            dt=self._dt,
            names=tuple(self._numbers),
            n_velocities=self._applied.shape[1],
            key=self._at.key + self._drive.matrix.tobytes(),
            at=self._at,
            drive=self._drive,
        )

    def _rollout_compiled(
        self, compiled: CompiledStep, controls: Array, record: tuple[str, ...], ids: IntArray | None
    ) -> dict[str, Array]:
        """Roll out as `rollout` does, with compiled code within the engine's steps."""
        reading = np.empty((*controls.shape[:2], 2 * self._n)) if READING in record else None
        out = compiled.rollout(controls, tuple(name for name in record if name != READING), ids, reading)
        return out if reading is None else out | {READING: reading}

    def _rollout_by_numpy(
        self, engine: batch.Batch, controls: Array, record: tuple[str, ...], ids: IntArray | None
    ) -> dict[str, Array]:
        """Roll out as `rollout` does, physics step for physics step with numpy."""
        rows = slice(None) if ids is None or len(ids) == engine.nsim else ids
        ids = None if isinstance(rows, slice) else ids
        bound = {name: engine.bind(name) for name in record if name != READING}
        out = {name: np.empty((*controls.shape[:2], *field.shape[1:])) for name, field in bound.items()}
        if READING in record:
            out[READING] = np.empty((*controls.shape[:2], 2 * self._n))
        chosen = self.choose(rows)
        looks = bool(chosen.resolver) or self._readings is not None
        motor = self._engine_state.motor(rows) if looks else None
        for k in range(controls.shape[1]):
            self._controls[rows] = controls[:, k]
            self._apply(chosen, motor)
            engine.step(ids)
            if looks:
                motor = self._engine_state.motor(rows)
                self._look(chosen, motor)
            if READING in record:
                out[READING][:, k] = self.reading(chosen)
            for name, field in bound.items():
                out[name][:, k] = field[rows]
        return out

    def _look(self, chosen: Chosen, motor: tuple[Array, Array]) -> None:
        """Let resolvers be read after a physics step, at motor angles and speeds (B', N) each."""
        if self._readings is not None and (due := self._readings.count(chosen.rows)) is not None:
            self._readings.look(chosen.rows, due, self._sense(chosen, *motor)[0])

    def _apply(self, chosen: Chosen, motor: tuple[Array, Array] | None) -> None:
        """Set the engine's applied torques for the next physics step, and what servos know, None if that is exact.

        Args:
            chosen: simulations.
            motor: their motor angles [rad] and speeds [rad/s], (B', N) each.
        """
        if motor is not None:
            error = self._error(chosen, *motor)
            self._controls[chosen.rows, 0 : 3 * self._n : 3] -= error.angle
            self._controls[chosen.rows, 1 : 3 * self._n : 3] -= error.speed
        if chosen.torque:
            memories = [memory[chosen.rows] for memory in self._memory]
            total, memories = step(chosen.torque, self.state(chosen), memories, self._dt, chosen.present)
            for memory, later in zip(self._memory, memories, strict=True):
                memory[chosen.rows] = later
            self._write(chosen, total)

    def _write(self, chosen: Chosen, total: Torques) -> None:
        """Set applied forces of the engine."""
        at = self._at
        motor, turning, behind = hinge_torques(self._drive, total)
        if motor is not None:
            self._motor[chosen.rows] = motor
        if turning is not None:
            self._applied[chosen.everyone, at.motor_qpos] = turning
        if behind is not None:
            self._applied[chosen.everyone, at.deflection_qpos] = behind[:, at.is_elastic]


def _rows_of(effect: Any, rows: IntArray | slice) -> Any:
    """The stacked effect for some of the machines."""
    if isinstance(rows, slice):
        return effect
    some = object.__new__(type(effect))
    for name, value in effect.values().items():
        object.__setattr__(some, name, value[rows])
    return some
