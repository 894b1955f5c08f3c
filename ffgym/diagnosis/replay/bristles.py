"""LuGre friction along measured speeds, of several models at once."""

from dataclasses import dataclass

import numpy as np

from ffgym.friction import LuGreParameters
from ffgym.types import Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Bristles:
    """Friction of one model along motor speeds, motor side, shape (T, M, N)."""

    torque: Array
    """[N m], viscous part included; opposes the motion."""
    sign: Array
    """LuGre-smoothed sign of the motor speed s = sigma_0 z / g(v) [1]."""


def along_speed(friction: LuGreParameters, speed: Array, dt: float) -> Bristles:
    """Friction of bristles that are relaxed at the first sample, at motor speeds (T, M, N) [rad/s] `dt` [s] apart.

    Between two samples the bristle equation is solved exactly for their mean speed.
    """
    keep, gain = friction.exact_bristle_factors(0.5 * (speed[1:] + speed[:-1]), dt)
    bristle = np.zeros_like(speed)
    z = bristle[0]
    for k in range(len(keep)):
        z = keep[k] * z + gain[k]
        bristle[k + 1] = z
    return Bristles(
        torque=friction.torque(bristle, speed),
        sign=friction.bristle_stiffness * bristle / friction.stribeck_level(speed),
    )
