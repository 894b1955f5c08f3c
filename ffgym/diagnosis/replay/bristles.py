"""LuGre friction along measured speeds, of several models at once."""

from dataclasses import dataclass

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.replay.banded import first_order
from ffgym.robot.friction import LuGreParameters


@dataclass(frozen=True, kw_only=True, eq=False)
class Bristles:
    """Friction of one model along motor speeds, motor side, shape (T, M, N)."""

    torque: Array
    """[N m], viscous part included; opposes the motion."""
    sign: Array
    """LuGre-smoothed sign of the motor speed s = sigma_0 z / g(v) [1]."""


def along_speed(friction: LuGreParameters, slip: Array, speed: Array, dt: float, load: float = 0.0) -> Bristles:
    """Friction of bristles along samples `dt` [s] apart, motor side.

    Between two samples the bristle equation is solved exactly for their mean speed; where the speed changes its sign,
    for the mean speed before that and then for the one after it. With the sum of both alone, bristles would still
    pull forwards at the first sample at which the motor is fast again, and their damping would be a peak of torque.

    Args:
        friction: model of all joints.
        slip: speed that moves the bristles [rad/s], shape (T, M, N).
        speed: speed of the motors, which viscous friction sees [rad/s].
        dt: sample time [s].
        load: of the bristles at the first sample, as a share of what tears them off; 0 is relaxed.
    """
    keep, gain = _bristle_factors(friction, slip, dt)
    start = load * friction.stribeck_level(0.0 * slip[0]) / friction.bristle_stiffness
    bristle = first_order(keep, gain, start)
    return Bristles(
        torque=friction.torque(bristle, slip) + friction.viscous * (speed - slip),
        sign=friction.bristle_stiffness * bristle / friction.stribeck_level(slip),
    )


def _bristle_factors(friction: LuGreParameters, slip: Array, dt: float) -> tuple[Array, Array]:
    """Factors (keep, gain) that lead bristles from each sample to the next, shape (T - 1, M, N)."""
    keep, gain = friction.exact_bristle_factors(0.5 * (slip[1:] + slip[:-1]), dt)
    turns = slip[1:] * slip[:-1] < 0.0
    rows = np.flatnonzero(turns.any(axis=(1, 2)))
    if len(rows):
        first, last, turns = slip[:-1][rows], slip[1:][rows], turns[rows]
        before = dt * np.divide(first, first - last, out=np.ones_like(first), where=turns)
        forth, forth_gain = friction.exact_bristle_factors(0.5 * np.where(turns, first, first + last), before)
        back, back_gain = friction.exact_bristle_factors(0.5 * last, dt - before)
        keep[rows], gain[rows] = forth * back, forth_gain * back + back_gain
    return keep, gain
