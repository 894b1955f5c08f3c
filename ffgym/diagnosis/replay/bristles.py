"""LuGre friction along measured speeds, of several models at once."""

from dataclasses import dataclass

from ffgym.diagnosis.replay.banded import first_order
from ffgym.friction import LuGreParameters
from ffgym.types import Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Bristles:
    """Friction of one model along motor speeds, motor side, shape (T, M, N)."""

    torque: Array
    """[N m], viscous part included; opposes the motion."""
    sign: Array
    """LuGre-smoothed sign of the motor speed s = sigma_0 z / g(v) [1]."""


def along_speed(friction: LuGreParameters, slip: Array, speed: Array, dt: float, load: float = 0.0) -> Bristles:
    """Friction of bristles along samples `dt` [s] apart, motor side.

    Between two samples the bristle equation is solved exactly for their mean speed.

    Args:
        friction: model of all joints.
        slip: speed that moves the bristles [rad/s], shape (T, M, N).
        speed: speed of the motors, which viscous friction sees [rad/s].
        dt: sample time [s].
        load: of the bristles at the first sample, as a share of what tears them off; 0 is relaxed.
    """
    keep, gain = friction.exact_bristle_factors(0.5 * (slip[1:] + slip[:-1]), dt)
    start = load * friction.stribeck_level(0.0 * slip[0]) / friction.bristle_stiffness
    bristle = first_order(keep, gain, start)
    return Bristles(
        torque=friction.torque(bristle, slip) + friction.viscous * (speed - slip),
        sign=friction.bristle_stiffness * bristle / friction.stribeck_level(slip),
    )
