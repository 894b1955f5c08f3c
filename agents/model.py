r"""Model feed-forward: inverse dynamics of a machine with physical effects.

Idea: a diagnosis names effects of a machine that its description lacks. Elastic feed-forward
(`ffgym.agents.elastic`) solves the flexible-joint equations along the reference; here they have the effects in them.
With the torque tau_e that effects put on spring (s), link (l) and motor (m), all else as in `ffgym.agents.elastic`,

.. math:: K \Delta + d \dot\Delta = \tau_l + s, \quad \tau_l = \tau_s(q, \dot q, \ddot q) - l
.. math:: u = \frac{\tau_l}{n} + J_m n (\ddot q + \ddot\Delta) + \tau_f(n (\dot q + \dot\Delta)) - m

and u_lff is u less the torque of the existing controller: its rigid feed-forward, and its servo, which sees -n Delta
and the errors of its resolver. All of it counts from the rest before the motion, where springs and servo integrals
carry gravity and effects. Effects are evaluated at the motion that the law brings about: at the leading motor's angle
and speed, at bristles that this speed bends, at the torque that the gearbox passes on.

A torque compensates what acts on motors, springs and links, and errors of the resolver. It cannot compensate a tool or
a tracker that is elsewhere than believed, nor a base or link that gives way: `left_alone` lists these effects. A gap
between teeth is crossed within some samples, as a motor cannot jump.

Source: as `ffgym.agents.elastic`, and the equations of `ffgym.effects` (docs/effects). Departures: springs with effects
bend as if at rest, then with the damping of the linear spring; an effect with memory on the motor sees the torque
without its own share (a delay d is taken back to first order in d); friction behind the elasticity bends the linear
spring, beside what effects make of it at samples (`ffgym.agents.model_arm`).

Run it:

    ffgym demo --robot machine.toml --agents none elastic model:machine.toml

Logged: nothing, the law learns nothing; `left_alone` lists the effects that it does not compensate.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import final

import numpy as np

from ffgym.agents.declaration import AgentEntry, declare
from ffgym.agents.elastic import ElasticLaw, elastic_law
from ffgym.agents.elastic_memory import ArmPast
from ffgym.agents.flexible_joints import Lead, bristles_within, given_torque, in_parts, limit_integral, motion_at
from ffgym.agents.model_along import ModelAlong, SideBySide
from ffgym.agents.model_arm import AheadOnArm, ModelArm
from ffgym.agents.model_memory import Carried, Past, Start, unpack_past
from ffgym.agents.model_springs import SpringEffects
from ffgym.agents.model_states import ModelStates, MotorEffects, state_between
from ffgym.control import CausalLaw, DynamicLuGreExact, LawStyle, Window
from ffgym.core.types import Array
from ffgym.effects import Effect, NativeEffect, ResolverEffect, TorqueEffect
from ffgym.paths import Reference
from ffgym.robot import RigidArm
from ffgym.robot.drive import Drive
from ffgym.simulation.plant import Machine, load_machine
from ffgym.simulation.plant.machine import check_same_controller


def model_law(
    machine: Machine | str | Path, controller: RigidArm | None = None, name: str = "model"
) -> "ElasticLaw | ModelLaw":
    """Make feed-forward from a machine; it is elastic feed-forward where effects only change numbers of the robot.

    Args:
        machine: model of the machine, or its file.
        controller: model behind the existing controller; defaults to the machine's robot without effects.
        name: name of the law.

    Raises:
        FFGymError: if the file cannot be read, or is of another robot than the controller's.
    """
    believed = machine if isinstance(machine, Machine) else load_machine(machine)
    known = controller or RigidArm(believed.robot)
    check_same_controller(believed.robot, known.robot)
    servo = believed.physical.servo  # which an effect may have tuned otherwise
    if servo is not believed.robot.servo:
        known = RigidArm(replace(known.robot, servo=servo))
    elastic = elastic_law(RigidArm(believed.physical), known, name)
    if not believed.torque_effects_without_engine and not believed.resolver_effects:
        return elastic
    return ModelLaw(machine=believed, elastic=elastic)


def left_alone(machine: Machine) -> tuple[Effect, ...]:
    """List effects of a machine that no torque compensates: misplaced or late sensors, base or link that gives way."""
    known = NativeEffect | TorqueEffect | ResolverEffect
    return tuple(effect for effect in machine.effects if not isinstance(effect, known))


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ModelLaw(CausalLaw):
    """Inverse dynamics along the reference of a machine with effects, added to the controller that is there."""

    machine: Machine
    """Model of the machine in the law."""
    elastic: ElasticLaw
    """The same law for the machine without torque and resolver effects."""

    @property
    def name(self) -> str:
        """Name of the law."""
        return self.elastic.name

    @property
    def preview(self) -> int:  # type: ignore[override]
        """Samples to see ahead."""
        return self.elastic.preview

    @property
    def n_joints(self) -> int:
        """Number of motors N."""
        return self.machine.robot.n_joints

    @cached_property
    def _springs(self) -> SpringEffects:
        return SpringEffects(machine=self.machine)

    @cached_property
    def _states(self) -> ModelStates:
        return ModelStates(machine=self.machine)

    @cached_property
    def _motors(self) -> MotorEffects:
        return MotorEffects(machine=self.machine)

    @cached_property
    def _friction(self) -> DynamicLuGreExact:
        return DynamicLuGreExact(self.machine.physical.friction)

    @property
    def _drive(self) -> Drive:
        return self.machine.physical.drive

    # Along whole references

    def torque(self, reference: Reference) -> Array:
        """Compute the torques of `step` for all samples."""
        return self.torques_along([reference])[0]

    def torques_along(self, references: Sequence[Reference]) -> list[Array]:
        """Compute the torques of `step` along references side by side, in blocks where springs alone remember."""
        if len({reference.robot.servo.control_dt for reference in references}) > 1:
            return [self.torque(reference) for reference in references]
        if self.elastic.arm_friction is not None or any(self._lengths[1]):
            return self.step_along(references)
        for reference in references:
            self.check_joints(reference)
        longest_first = sorted(range(len(references)), key=lambda i: -len(references[i].t))
        motions = SideBySide.of([references[i] for i in longest_first], self.preview)
        past = self._past(self.initial_memory(motions.first_window(self.preview)))
        along = ModelAlong(
            elastic=self.elastic,
            springs=self._springs,
            states=self._states,
            motors=self._motors,
            friction=self._friction,
        )
        torques = dict(zip(longest_first, along.torques(motions, past), strict=True))
        return [torques[i] for i in range(len(references))]

    # Sample by sample

    def initial_memory(self, window: Window) -> Array:
        """Return the memory (`Past`) at rest before the motion."""
        dt, reach, q, still = window.dt, self.preview - 2, window.q[..., 0, :], np.zeros_like(window.q[..., 0, :])
        start, springs, motors = self._rest(q)
        arm = None if self.elastic.arm_friction is None else ArmPast.relaxed(still)
        ahead = None if arm is None else still
        # torque carried from rest to the samples ahead
        rows = [Carried(load=start.load, bend=start.bend, reaction=still)]
        for k in range(reach + 2):
            found, springs, ahead = self._carry(window, k, start, rows[-1], springs, ahead)
            rows.append(found)
        rows = [rows[1]] * reach + rows[1:]  # it rested before
        past = Past(
            start=start,
            carried=tuple(rows[1:-1]),
            time=still,
            lead=self._lead(rows[:-1], start, dt),
            integral=still,
            bristle=still,
            lost=still,
            springs=springs,
            motors=motors,
            arm=arm,
            arm_ahead=ahead,
        )
        return self._advance(past, window, 0, rows[-1])[-1].pack()

    def step(self, memory: Array, window: Window) -> tuple[Array, Array]:
        """Return the torque at sample 1, and the memory one sample on."""
        past = self._past(memory)
        newest, springs, ahead = self._carry(
            window, self.preview, past.start, past.carried[-1], past.springs, past.arm_ahead
        )
        past = replace(past, springs=springs, arm_ahead=ahead)
        command, seen, lost, later = self._advance(past, window, 1, newest)
        needed = command - self._drive.motor_torque(past.start.load) + past.lost + lost + past.start.added
        # less the torque of the existing controller
        given = given_torque(self.elastic.known, *motion_at(window, 1), seen, past.integral)
        carried = self._drive.motor_torque(past.start.load) - past.start.added
        integral = limit_integral(later.integral, self.elastic.known, self._drive.joint_torque(carried))
        return needed - given, replace(later, integral=integral).pack()

    def _advance(self, past: Past, window: Window, k: int, newest: Carried) -> tuple[Array, Lead, Array, Past]:
        """Advance from sample `k` of the window to the next one.

        Returns:
            Torque at sample `k` that keeps motors and links there but for friction and effects [N m], motor side, the
            lead as the servo sees it there, friction less torque of effects within the step as its part of that sample
            [N m], and the memory after the step.
        """
        # states at both ends of the step
        dt, start, rows = window.dt, past.start, (*past.carried, newest)
        middle = len(rows) // 2
        motion, next_motion, lead = motion_at(window, k), motion_at(window, k + 1), self._lead(rows, start, dt)
        arm = ModelArm.along(self.elastic.arm_friction, past, motion[1], next_motion[1], dt)
        leads = (past.lead, lead) if arm is None else arm.leads(past.lead, lead)
        here = self._states.at(motion, rows[middle - 1], leads[0], start, past.time)
        after = self._states.at(next_motion, rows[middle], leads[1], start, past.time + dt)
        # friction less torque of effects, in the middle of sub-steps
        law, between = self._friction, state_between(here, after, self._friction.shares)
        more = None if arm is None else arm.motor_speed
        middles, speeds, bristle = bristles_within(law, past.bristle, here.motor_speed, after.motor_speed, dt, more)
        friction = (1 - self.machine.physical.arm_share) * law.friction.torque(middles, speeds)
        between = (between if arm is None else arm.within(between)).with_values(bristle=middles)
        added, motors = self._motors.within(between, friction, past.motors, dt)
        lost, next_lost = in_parts(friction - added)
        # lead as the servo sees it, and its integral
        seen, next_seen = self._states.seen(here, past.lead, start), self._states.seen(after, lead, start)
        later = Past(
            start=start,
            carried=rows[1:],
            time=past.time + dt,
            lead=lead,
            integral=past.integral + 0.5 * dt * (seen.angle + next_seen.angle),
            bristle=bristle,
            lost=next_lost,
            springs=past.springs,
            motors=motors,
            arm_ahead=past.arm_ahead,
        )
        if arm is None:
            return here.command, seen, lost, later
        return arm.command(here.command), arm.seen(seen), lost, arm.later(later)

    def own_error(self, memory: Array, window: Window) -> tuple[Array, Array]:
        """Return the motor error and rate that the law causes by its lead, without errors of resolvers."""
        past = self._past(memory)
        speed, next_speed = (motion_at(window, k)[1] for k in (1, 2))
        arm = ModelArm.along(self.elastic.arm_friction, past, speed, next_speed, window.dt)
        lead = past.lead if arm is None else arm.seen(past.lead)
        return -self._drive.motor_angle(lead.angle), -self._drive.motor_angle(lead.speed)

    def instant_error(self, memory: Array) -> tuple[Array, Array]:
        """Return the same at the instant itself, where friction on the arm may jump."""
        past = self._past(memory)
        angle, speed = past.lead.angle, past.lead.speed
        if past.arm is not None:
            angle, speed = angle + past.arm.state.lead, speed + past.arm.state.lead_speed
        return -self._drive.motor_angle(angle), -self._drive.motor_angle(speed)

    def _past(self, memory: Array) -> Past:
        springs, motors = self._lengths
        return unpack_past(
            memory, self.n_joints, 2 * (self.preview - 2), springs, motors, arm=self.elastic.arm_friction is not None
        )

    @cached_property
    def _lengths(self) -> tuple[list[int], list[int]]:
        """Count the numbers per joint that effects on springs and on motors remember."""
        _, springs, motors = self._rest(np.zeros(self.n_joints))
        return [memory.shape[-1] for memory in springs], [memory.shape[-1] for memory in motors]

    # Parts of the equation in the head of this file, shape (..., N)

    def _rest(self, q: Array) -> tuple[Start, list[Array], list[Array]]:
        """Find the equilibrium at `q`, and the memories of effects on springs and on motors there."""
        still = np.zeros_like(q)
        carried, springs = self._springs.rest(self.elastic.links(q, still, still), q)
        error = self._states.reading_error(q)
        none = Lead(angle=still, speed=still, acceleration=still)
        start = Start(load=carried.load, bend=carried.bend, added=carried.reaction, error=error)
        added, motors = self._motors.rest(self._states.at((q, still, still), carried, none, start, still))
        return replace(start, added=carried.reaction + added), springs, motors

    def _carry(
        self,
        window: Window,
        k: int,
        start: Start,
        before: Carried,
        springs: list[Array],
        bristle: Array | None,
    ) -> tuple[Carried, list[Array], Array | None]:
        """Compute the torque that gearboxes and springs carry at sample `k`, and the memories of effects then.

        `bristle` is that of friction behind the elasticity a sample before, None without it; that at `k` comes last.
        """
        q, motor_dq, motor_ddq = motion_at(window, k)
        needed, dq = self.elastic.links(q, motor_dq, motor_ddq), self._drive.joint_angle(motor_dq)
        if self.elastic.arm_friction is None or bristle is None:
            return *self._springs.next(needed, q, dq, start.bend, before, springs, window.dt), None
        last = window.motor_dq[..., max(k - 1, 0), :]
        arm = AheadOnArm.next(self.elastic.arm_friction, bristle, last, motor_dq, window.dt if k else 0.0)
        carried, springs = self._springs.next(
            needed + arm.load, q, dq, start.bend, arm.bent(before), springs, window.dt
        )
        return arm.unbent(carried), springs, arm.bristle

    def _lead(self, rows: Sequence[Carried], start: Start, dt: float) -> Lead:
        """Compute the lead at the middle one of an odd number of samples."""
        return self.elastic.lead(np.stack([row.bend - start.bend for row in rows], axis=-2), dt)


FITTED = "model_fitted"
"""Row of feed-forward from models that were fitted to recordings of the workcell."""

declare(
    AgentEntry(
        name="model",
        title="feed-forward from a machine file",
        about="Elastic feed-forward from a machine file, with the effects that stand in it.",
        track="causal, nominal parameters",
        order=13,
        page="model.md",
        style=LawStyle(label="model feed-forward", colour="#1B7837", marker="h"),
        make=lambda setting: model_law(Machine(robot=setting.robot), setting.controller or setting.arm),
        make_from=lambda machine, setting, name: model_law(machine, setting.controller or setting.arm, name),
        on_leaderboard=False,  # without a file it is elastic
    ),
    AgentEntry(
        name=FITTED,
        title="fitted and diagnosed model",
        about="Elastic feed-forward from a model whose friction, rotors, masses and springs were fitted to 88 s of "
        "recordings of the machine, and which has the effects that a diagnosis of these recordings found.",
        track="causal, nominal parameters",
        order=14,
        page="model.md",
        load=lambda path, arm: model_law(path, arm, FITTED),
    ),
)
