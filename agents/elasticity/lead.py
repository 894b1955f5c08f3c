"""How far a motor must lead its arm: the spring between them, solved along a motion that is known in samples."""

from dataclasses import dataclass
from functools import cache
from math import factorial

import numpy as np

from ffgym.core.types import Array
from ffgym.robot.drive import Drive


@dataclass(frozen=True, kw_only=True, eq=False)
class Lead:
    """Motor angle minus arm angle, link side, with its derivatives; shape (..., N) each."""

    angle: Array
    """[rad]."""
    speed: Array
    """[rad/s]."""
    acceleration: Array
    """[rad/s^2]."""


def lead_between(bend: Array, relaxation: Array, dt: float) -> Lead:
    r"""Lead at the middle one of an odd number of samples.

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


def error_of(angle: Array, speed: Array, drive: Drive) -> tuple[Array, Array]:
    """Errors [rad], [rad/s], reference - motor, motor side, of motors that lead by an angle and a speed, link side."""
    return -drive.motor_angle(angle), -drive.motor_angle(speed)


@cache
def _derivatives(reach: int) -> Array:
    """Weights of the derivatives 0 to 2 w at the middle of 2 w + 1 samples with unit distance, a row each."""
    at = np.arange(-reach, reach + 1, dtype=np.float64)
    powers = np.linalg.inv(np.vander(at, increasing=True))  # from samples to coefficients of the polynomial
    return powers * np.array([[float(factorial(k))] for k in range(len(at))])
