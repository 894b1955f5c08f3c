"""Parts of elastic feed-forward: the lead of the motors, the torque of the controller that is there, mean friction.

A drive joins samples of torque by straight lines. Where a motor turns round, friction changes within a few
milliseconds: a sample of it that happens to fall there gives too much or too little momentum. The average over the step
before and the step after, weighted by the share that the sample has in the straight lines, gives the right one.
"""

from dataclasses import dataclass
from functools import cache
from math import factorial
from typing import Self

import numpy as np

from ffgym.control import DynamicLuGreExact, Window
from ffgym.control.lugre_laws import chain_sub_steps
from ffgym.core.types import Array
from ffgym.robot import RigidArm


@dataclass(frozen=True, kw_only=True, eq=False)
class Lead:
    """Motor angle minus arm angle, link side, with its derivatives; shape (..., N) each."""

    angle: Array
    """[rad]."""
    speed: Array
    """[rad/s]."""
    acceleration: Array
    """[rad/s^2]."""

    def __add__(self, other: Self) -> Self:
        return type(self)(
            angle=self.angle + other.angle,
            speed=self.speed + other.speed,
            acceleration=self.acceleration + other.acceleration,
        )


def motion_at(window: Window, k: int) -> tuple[Array, Array, Array]:
    """Return position, motor speed and motor acceleration of the reference at sample `k`."""
    return window.q[..., k, :], window.motor_dq[..., k, :], window.motor_ddq[..., k, :]


def lead_between(bend: Array, relaxation: Array, dt: float) -> Lead:
    r"""Compute the lead at the middle one of an odd number of samples.

    It solves :math:`\Delta + T \dot\Delta = x` for the polynomial x through the samples, which has one solution that is
    a polynomial too: :math:`\Delta = x - T \dot x + T^2 \ddot x - \ldots`, a finite sum.

    Args:
        bend: x, torque of the springs / stiffness [rad], at 2 w + 1 samples, shape (..., 2 w + 1, N).
        relaxation: T, damping / stiffness of the springs [s], shape (N,).
        dt: time between the samples [s].
    """
    table = _derivatives(bend.shape[-2] // 2)
    lead = np.zeros_like(bend[..., 0, :])
    found = []
    for order in range(len(table) - 1, -1, -1):  # the k-th derivative is x^(k) - T times the next one
        derivative = np.zeros_like(lead)
        for k, weight in enumerate(table[order]):  # a loop, so that no shape changes the rounding
            derivative += weight * bend[..., k, :]
        lead = derivative / dt**order - relaxation * lead
        found.append(lead)
    return Lead(angle=found[-1], speed=found[-2], acceleration=found[-3])


@cache
def _derivatives(reach: int) -> Array:
    """Compute weights of derivatives 0 to 2 w at the middle of 2 w + 1 samples with unit distance, a row each."""
    at = np.arange(-reach, reach + 1, dtype=np.float64)
    powers = np.linalg.inv(np.vander(at, increasing=True))  # from samples to coefficients of the polynomial
    return powers * np.array([[float(factorial(k))] for k in range(len(at))])


def given_torque(
    controller: RigidArm, q: Array, motor_dq: Array, motor_ddq: Array, lead: Lead, integral: Array
) -> Array:
    """Compute the torque of the existing controller [N m], beyond gravity at the start, shape (..., N).

    The servo sees the motor ahead of its reference by the lead, and pulls it back; it is in equilibrium at the start.

    Args:
        controller: rigid dynamics and servo of the existing controller.
        q: joint position of the reference [rad], shape (..., N).
        motor_dq: motor speed of the reference [rad/s], shape (..., N).
        motor_ddq: motor acceleration of the reference [rad/s^2], shape (..., N).
        lead: how far the motors lead beyond their lead at the start.
        integral: integral of the lead since the start, link side [rad s], shape (..., N).
    """
    drive, servo = controller.robot.drive, controller.robot.servo
    rigid = drive.motor_torque(links_torque(controller, q, motor_dq, motor_ddq, load=False))
    rigid += drive.rotor_inertia * motor_ddq
    angle, speed, sum_of_angle = (drive.motor_angle(part) for part in (lead.angle, lead.speed, integral))
    return rigid - (servo.position_gain * angle + servo.velocity_gain * speed + servo.integral_gain * sum_of_angle)


def limit_integral(integral: Array, controller: RigidArm, load: Array) -> Array:
    """Limit the integral of the lead as the servo does: its integral ends where it alone would give the peak torque.

    Args:
        integral: integral of the lead since the start, link side [rad s], shape (..., N).
        controller: rigid dynamics and servo of the existing controller.
        load: torque that holds the links at the start, carried by the servo's integral, link side [N m], (..., N).
    """
    drive, gain = controller.robot.drive, controller.robot.servo.integral_gain
    reach = np.divide(drive.peak_torque, gain, out=np.full_like(gain, np.inf), where=gain > 0)
    carried = np.divide(drive.motor_torque(load), gain, out=np.zeros_like(load), where=gain > 0)
    turned = drive.motor_angle(integral)
    ended = np.clip(turned, carried - reach, carried + reach)
    beyond = np.any(ended != turned, axis=-1, keepdims=True)
    return np.where(beyond, drive.joint_angle(ended), integral)


def sum_limited(start: Array, increments: Array, controller: RigidArm, load: Array) -> Array:
    """Sum `increments` (T, ..., N) from `start` (..., N) [rad s], limited by `limit_integral`, (T + 1, ..., N)."""
    sums = np.add.accumulate(np.concatenate([start[None], increments]))
    if np.array_equal(limit_integral(sums[1:], controller, load), sums[1:]):
        return sums
    for k, increment in enumerate(increments):
        sums[k + 1] = limit_integral(sums[k] + increment, controller, load)
    return sums


def links_torque(arm: RigidArm, q: Array, motor_dq: Array, motor_ddq: Array, *, load: bool) -> Array:
    """Compute the torque of the links, link side [N m], for a motion of any shape (..., N).

    `load` adds the torque at rest: gravity, and springs between links.
    """
    drive = arm.robot.drive
    motion = (q, drive.joint_angle(motor_dq), drive.joint_angle(motor_ddq))
    rows = [part.reshape(-1, arm.robot.n_joints) for part in motion]
    torque = arm.inverse_dynamics(*rows, gravity=load)
    if load:
        torque += arm.spring_torque(rows[0])
    return torque.reshape(q.shape)


def step_friction(
    law: DynamicLuGreExact, z: Array, dq: Array, next_dq: Array, dt: float, added: Array | None = None
) -> tuple[Array, Array, Array]:
    """Compute friction within a control step, as parts of the torque at its two ends, and the bristles after it.

    Args:
        law: friction model, and in how many sub-steps a step is resolved.
        z: bristle deflection at the start [rad], shape (..., N).
        dq: motor speed at the start [rad/s], shape (..., N).
        next_dq: motor speed at the end [rad/s], shape (..., N).
        dt: length of the step [s].
        added: speed beside the straight line from start to end, in the middle of each sub-step [rad/s], (S, ..., N).

    Returns:
        Parts that belong to the start and to the end [N m], and the bristle deflection at the end [rad], (..., N) each.
        The parts of a constant friction are half of it.
    """
    middles, speeds, z = bristles_within(law, z, dq, next_dq, dt, added)
    return *in_parts(law.friction.torque(middles, speeds)), z


def bristles_within(
    law: DynamicLuGreExact, z: Array, dq: Array, next_dq: Array, dt: float, added: Array | None = None
) -> tuple[Array, Array, Array]:
    """Integrate the bristles within a control step; arguments as in `step_friction`.

    Returns:
        Deflection [rad] and motor speed [rad/s] in the middle of each sub-step, (S, ..., N), and the deflection at the
        end, (..., N).
    """
    speeds, factors = _resolve(law, dq, next_dq, dt, added)
    middles, z = _bend(z, *factors)
    return middles, speeds, z


def _resolve(
    law: DynamicLuGreExact, dq: Array, next_dq: Array, dt: float, added: Array | None = None
) -> tuple[Array, tuple[Array, Array]]:
    """Compute motor speeds in the middle of sub-steps [rad/s], and factors of the bristles there, (S, ..., N) each."""
    speeds = np.stack([dq + (next_dq - dq) * share for share in law.shares])
    if added is not None:
        speeds = speeds + added
    return speeds, law.friction.exact_bristle_factors(speeds, dt / law.n_substeps)


def _bend(z: Array, keeps: Array, gains: Array) -> tuple[Array, Array]:
    """Bend bristles by factors of sub-steps (S, ..., N); return deflections in their middles, and at the end [rad]."""
    middles = np.empty_like(keeps)
    for k, (keep, gain) in enumerate(zip(keeps, gains, strict=True)):
        next_z = keep * z + gain
        middles[k], z = 0.5 * (z + next_z), next_z
    return middles, z


def bristles_along(
    law: DynamicLuGreExact, z: Array, dq: Array, next_dq: Array, dt: float
) -> tuple[Array, Array, Array]:
    """Integrate the bristles through K steps one after the other, as `bristles_within` does in each.

    Args:
        law: friction model.
        z: bristle deflection at the start of the first step [rad], (..., N).
        dq: motor speed at the start of each step [rad/s], (K, ..., N).
        next_dq: motor speed at their ends [rad/s], (K, ..., N).
        dt: length of a step [s].

    Returns:
        Deflection [rad] and motor speed [rad/s] in the middle of each sub-step, (S, K, ..., N), and the deflection at
        the end of the last step, (..., N).
    """
    speeds, factors = _resolve(law, dq, next_dq, dt)
    # deflections at the ends of sub-steps, in the order of time
    ends = np.empty((speeds.shape[0] * speeds.shape[1] + 1, *z.shape))
    ends[0] = z
    keep, gain = (factor.swapaxes(0, 1).reshape(-1, *z.shape) for factor in factors)
    for now, after, kept, gained in zip(ends[:-1], ends[1:], keep, gain, strict=True):
        np.multiply(kept, now, out=after)
        after += gained
    middles = 0.5 * (ends[:-1] + ends[1:])
    return middles.reshape(len(dq), -1, *z.shape).swapaxes(0, 1), speeds, ends[-1]


def in_parts(torques: Array) -> tuple[Array, Array]:
    """Split torques in the middle of S sub-steps (S, ..., N) into parts of the two ends of the step [N m]."""
    n = len(torques)
    torques = torques / n
    start, end = np.zeros_like(torques[0]), np.zeros_like(torques[0])
    for torque, share in zip(torques, (np.arange(n) + 0.5) / n, strict=True):  # a loop, so that no shape changes bits
        start, end = start + (1 - share) * torque, end + share * torque
    return start, end


def friction_along(law: DynamicLuGreExact, motor_dq: Array, dt: float, added: Array | None = None) -> Array:
    """Average friction around samples of the motor speed (T, N) [rad/s], from relaxed bristles on [N m], (T - 1, N).

    The last sample has no step behind it, and is left out. `added` is as in `step_friction`, (S, T - 1, N).
    """
    speeds, factors = _resolve(law, motor_dq[:-1], motor_dq[1:], dt, added)
    if added is None:
        z = accumulate(*chain_sub_steps(*factors))
    else:  # the deflection after a step is linear in the one before it
        from_none, from_one = (_bend(np.full_like(motor_dq[:-1], z), *factors)[1] for z in (0.0, 1.0))
        z = accumulate(from_one - from_none, from_none)
    middles, _ = _bend(z, *factors)
    return join_parts(*in_parts(law.friction.torque(middles, speeds)))


def join_parts(start: Array, end: Array) -> Array:
    """Add the parts of each step's start (T, N) and those of the end of the step before it [N m], shape (T, N)."""
    joined = start.copy()
    joined[1:] += end[:-1]
    return joined


def accumulate(keep: Array, gain: Array) -> Array:
    """Solve x[k + 1] = keep[k] x[k] + gain[k] from 0 on, for all steps but the last, shape as both (T, N)."""
    values = np.zeros_like(gain)
    for k in range(len(gain) - 1):
        values[k + 1] = keep[k] * values[k] + gain[k]
    return values
