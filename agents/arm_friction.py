r"""Friction behind the elasticity in elastic feed-forward: what it asks of the motors on a reference.

The link is to turn at the speed of the reference, so that its friction is known before it acts. With the share s of the
joint's LuGre friction on the arm, bristles z of their own and gear ratio n, the spring must carry (link side)

.. math:: \tau_a = s \, n \, \tau_f(z, n \dot q), \qquad K \Delta_a + d \dot\Delta_a = \tau_a

and the motor leads by Delta_a more than the links alone ask for. Where a joint turns round, tau_a changes its sign
within a few milliseconds, and the lead jumps by up to 2 s n f_c / K: too fast for a curve through samples. Both
equations are solved in sub-steps of the control step; torque, lead, and its derivatives are then averaged around
samples as friction of the motor is (`ffgym.agents.flexible_joints`). The averages of the derivatives are differences of
leads and of mean speeds, so that the lead itself need not be smooth.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np

from ffgym.agents.flexible_joints import Lead, accumulate, in_parts, join_parts
from ffgym.control import DynamicLuGreExact
from ffgym.core.types import Array
from ffgym.robot.drive import Drive


@dataclass(frozen=True, kw_only=True, eq=False)
class ArmState:
    """State of the friction on the arm at a sample, (..., N) each."""

    bristle: Array
    """Deflection of the bristles on the link, motor units [rad]."""
    lead: Array
    """Lead Delta_a of the motor, link side [rad]."""
    lead_speed: Array
    """Its speed just before the sample [rad/s]."""

    @classmethod
    def relaxed(cls, like: Array) -> Self:
        """Return the state of an arm that rests, in the shape of an array (..., N)."""
        return cls(bristle=np.zeros_like(like), lead=np.zeros_like(like), lead_speed=np.zeros_like(like))


@dataclass(frozen=True, kw_only=True, eq=False)
class Asked:
    """Averages around a sample of what friction on the arm asks for, or the part of them from one step, (..., N)."""

    torque: Array
    """Friction tau_a, link side [N m]."""
    lead: Lead
    """Lead of the motor and its derivatives, link side."""

    def __add__(self, other: Self) -> Self:
        return type(self)(torque=self.torque + other.torque, lead=self.lead + other.lead)


@dataclass(frozen=True, kw_only=True, eq=False)
class ArmStep:
    """Friction of the arm in the S sub-steps of a control step."""

    torque: Array
    """Friction tau_a in the middle of sub-steps, link side [N m], shape (S, ..., N)."""
    lead: Array
    """Lead Delta_a there, link side [rad]."""
    lead_speed: Array
    """Mean speed of the lead in each sub-step [rad/s]."""
    across: Array
    """Change of the lead over the whole step [rad], shape (..., N)."""
    after: ArmState
    """State at the end of the step."""

    @property
    def mean_lead(self) -> Array:
        """Mean lead of the step, link side [rad], shape (..., N)."""
        start, end = in_parts(self.lead)
        return start + end

    def parts(self, dt: float) -> tuple[Asked, Asked]:
        """Split torque and lead of a step of length `dt` [s] into parts of the averages at its start and at its end."""
        ends = zip(in_parts(self.torque), in_parts(self.lead), in_parts(self.lead_speed), (1, -1), strict=True)
        start, end = (
            Asked(torque=torque, lead=Lead(angle=angle, speed=speed, acceleration=sign * self.across / dt**2))
            for torque, angle, speed, sign in ends
        )
        return start, end

    def around(self, dt: float) -> Asked:
        """Return the averages around the starts of T steps that follow each other, from rest on, (T, N) each."""
        start, end = self.parts(dt)
        found = (
            (getattr(part, name) for part in (start.lead, end.lead)) for name in ("angle", "speed", "acceleration")
        )
        angle, speed, acceleration = (join_parts(*parts) for parts in found)
        lead = Lead(angle=angle, speed=speed, acceleration=acceleration)
        return Asked(torque=join_parts(start.torque, end.torque), lead=lead)


@dataclass(frozen=True, kw_only=True, eq=False)
class ReferenceArmFriction:
    """LuGre friction on the links of a robot."""

    law: DynamicLuGreExact
    """Friction of both sides together, and in how many sub-steps a control step is resolved."""
    drive: Drive
    share: Array
    """Share s of the friction that acts on the arm [1], shape (N,)."""

    @cached_property
    def _relaxation(self) -> Array:
        """Time constant of the springs d / K [s], shape (N,)."""
        return self.drive.joint_damping / self.drive.joint_stiffness

    def within(self, past: ArmState, motor_dq: Array, next_motor_dq: Array, dt: float) -> ArmStep:
        """Solve the equations in the head of this file over a control step, from the state `past` on.

        Args:
            past: state at the start of the step.
            motor_dq: motor speed of the reference at the start [rad/s], shape (..., N).
            next_motor_dq: motor speed of the reference at the end [rad/s], shape (..., N).
            dt: length of the step [s].
        """
        # speeds of the link in motor units; bristles, and friction at the ends of the sub-steps
        n, friction = self.law.n_substeps, self.law.friction
        start, end = self._link_speed(motor_dq), self._link_speed(next_motor_dq)
        middles, ends = (
            [start + (end - start) * share for share in shares] for shares in (self.law.shares, np.arange(n + 1) / n)
        )
        z, bends = past.bristle, [self._bend(past.bristle, ends[0])]
        for keep, gain, speed in zip(*friction.exact_bristle_factors(np.stack(middles), dt / n), ends[1:], strict=True):
            z = keep * z + gain
            bends.append(self._bend(z, speed))
        bend = np.stack(bends)
        # lead of the motor: exact solution where the bend runs straight within a sub-step
        decay, lags = self._decay(dt / n), self._relaxation * (bend[1:] - bend[:-1]) / (dt / n)
        leads = [past.lead]
        for before, after, lag in zip(bend[:-1], bend[1:], lags, strict=True):
            leads.append(after - lag + (leads[-1] - before + lag) * decay)
        lead = np.stack(leads)
        lead_speed = (lead[1:] - lead[:-1]) / (dt / n)
        stiffness = np.where(self.drive.is_rigid, 0.0, self.drive.joint_stiffness)
        return ArmStep(
            torque=stiffness * (0.5 * (bend[:-1] + bend[1:])),
            lead=0.5 * (lead[:-1] + lead[1:]),
            lead_speed=lead_speed,
            across=lead[-1] - lead[0],
            after=ArmState(bristle=z, lead=lead[-1], lead_speed=lead_speed[-1]),
        )

    def along(self, motor_dq: Array, dt: float) -> ArmStep:
        """Solve the equations along motor speeds (T, N) [rad/s], from rest on; every step at once, (S, T - 1, N)."""
        # bristles, then leads, at the samples: both are linear in their start
        link_dq, start, end = self._link_speed(motor_dq), motor_dq[:-1], motor_dq[1:]
        past = replace(ArmState.relaxed(start), bristle=accumulate(*self.law.advance(link_dq[:-1], link_dq[1:], dt)))
        kept = np.broadcast_to(self._decay(dt / self.law.n_substeps) ** self.law.n_substeps, start.shape)
        lead = accumulate(kept, self.within(past, start, end, dt).after.lead)
        return self.within(replace(past, lead=lead), start, end, dt)

    def at(self, bristle: Array, motor_dq: Array) -> Array:
        """Compute the friction tau_a at a sample, link side [N m], (..., N); arguments as `ArmState` and `within`."""
        return self.share * self.drive.gear_ratio * self.law.friction.torque(bristle, self._link_speed(motor_dq))

    def slide(self, bristle: Array, motor_dq: Array, next_motor_dq: Array, dt: float) -> Array:
        """Compute the deflection of the bristles at the end of a step; arguments as `at` and `within`."""
        return self.law.slide(bristle, self._link_speed(motor_dq), self._link_speed(next_motor_dq), dt)[1]

    def _link_speed(self, motor_dq: Array) -> Array:
        """Compute the speed of the links in motor units [rad/s], where motors turn at `motor_dq`."""
        return self.drive.gear_ratio * self.drive.joint_angle(motor_dq)

    def _bend(self, z: Array, speed: Array) -> Array:
        """Bend of the spring that carries the friction at rest [rad], link side."""
        return self.share * self.drive.gear_ratio * self.law.friction.torque(z, speed) / self.drive.joint_stiffness

    def _decay(self, h: float) -> Array:
        """Share of a lead without its cause that is left after a sub-step of `h` [s], shape (N,)."""
        turns = np.divide(h, self._relaxation, out=np.full_like(self._relaxation, np.inf), where=self._relaxation > 0)
        return np.exp(-turns)
