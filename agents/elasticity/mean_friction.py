"""Friction as a drive can follow it that joins torques by straight lines: averages around the samples.

Where a motor turns round, friction changes within a few milliseconds. A sample of it that happens to fall there, joined
to its neighbours by straight lines, gives too much or too little momentum. The average over the step before and the
step after, weighted by the share that the sample has in the straight lines, gives the right one.
"""

import numpy as np

from ffgym.control import DynamicLuGreExact
from ffgym.core.types import Array


def step_friction(law: DynamicLuGreExact, z: Array, dq: Array, next_dq: Array, dt: float) -> tuple[Array, Array, Array]:
    """Friction within a control step, as parts of the torque at its two ends, and the bristles after it.

    Args:
        law: friction model, and in how many sub-steps a step is resolved.
        z: bristle deflection at the start [rad], shape (..., N).
        dq: motor speed at the start [rad/s], shape (..., N).
        next_dq: motor speed at the end [rad/s], shape (..., N).
        dt: length of the step [s].

    Returns:
        Parts that belong to the start and to the end [N m], and the bristle deflection at the end [rad], (..., N) each.
        The parts of a constant friction are half of it.
    """
    middles, speeds, z = bristles_within(law, z, dq, next_dq, dt)
    return *in_parts(law.friction.torque(middles, speeds)), z


def bristles_within(
    law: DynamicLuGreExact, z: Array, dq: Array, next_dq: Array, dt: float
) -> tuple[Array, Array, Array]:
    """Bristles within a control step; arguments as in `step_friction`.

    Returns:
        Deflection [rad] and motor speed [rad/s] in the middle of each sub-step, (S, ..., N), and the deflection at the
        end, (..., N).
    """
    speeds = np.stack([dq + (next_dq - dq) * share for share in law.shares])
    middles = np.empty_like(speeds)
    for k, (keep, gain) in enumerate(
        zip(*law.friction.exact_bristle_factors(speeds, dt / law.n_substeps), strict=True)
    ):
        next_z = keep * z + gain
        middles[k], z = 0.5 * (z + next_z), next_z
    return middles, speeds, z


def in_parts(torques: Array) -> tuple[Array, Array]:
    """Parts of torques in the middle of S sub-steps (S, ..., N) that belong to the two ends of the step [N m]."""
    n = len(torques)
    torques = torques / n
    start, end = np.zeros_like(torques[0]), np.zeros_like(torques[0])
    for torque, share in zip(torques, (np.arange(n) + 0.5) / n, strict=True):  # a loop, so that no shape changes bits
        start, end = start + (1 - share) * torque, end + share * torque
    return start, end


def friction_along(law: DynamicLuGreExact, motor_dq: Array, dt: float) -> Array:
    """Averaged friction at samples of the motor speed (T, N) [rad/s], from relaxed bristles on [N m], (T - 1, N).

    The last sample has no step behind it, and is left out.
    """
    keep, gain = law.advance(motor_dq[:-1], motor_dq[1:], dt)
    z = np.zeros_like(motor_dq)
    for k in range(len(keep)):
        z[k + 1] = keep[k] * z[k] + gain[k]
    start, end, _ = step_friction(law, z[:-1], motor_dq[:-1], motor_dq[1:], dt)
    start[1:] += end[:-1]
    return start
