"""Friction as a drive can follow it that joins torques by straight lines: averages around the samples.

Where a motor turns round, friction changes within a few milliseconds. A sample of it that happens to fall there, joined
to its neighbours by straight lines, gives too much or too little momentum. The average over the step before and the
step after, weighted by the share that the sample has in the straight lines, gives the right one.
"""

import numpy as np

from ffgym.control import DynamicLuGreExact
from ffgym.types import Array


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
    shares = (np.arange(law.n_substeps) + 0.5) / law.n_substeps
    speeds = np.stack([dq + (next_dq - dq) * share for share in shares])
    middles = np.empty_like(speeds)
    for k, (keep, gain) in enumerate(
        zip(*law.friction.exact_bristle_factors(speeds, dt / law.n_substeps), strict=True)
    ):
        next_z = keep * z + gain
        middles[k], z = 0.5 * (z + next_z), next_z
    torques = law.friction.torque(middles, speeds) / law.n_substeps
    start, end = np.zeros_like(z), np.zeros_like(z)
    for torque, share in zip(torques, shares, strict=True):  # a loop, so that no shape changes the rounding
        start, end = start + (1 - share) * torque, end + share * torque
    return start, end, z


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
