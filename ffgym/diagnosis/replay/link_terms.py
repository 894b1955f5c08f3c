"""What the links ask for along measured motions: inertia matrices, and the torque that a motion without springs takes.

MuJoCo evaluates them at every n-th sample, fast enough to follow poses, and between those they are interpolated; the
accelerations, which change fast, are multiplied in at every sample.
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from ffgym.robot import RigidArm
from ffgym.types import Array

_PERIOD = 0.004
"""Time between evaluations [s]; chosen: the usual control period, in which no pose changes by much."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LinkTerms:
    r"""Of :math:`M(q) \ddot q + h(q, \dot q)` along M motions of T samples, link side."""

    mass: Array
    """M(q) [kg m^2], shape (T, M, N, N), without rotors."""
    bias: Array
    """h: gravity, springs between links, Coriolis and centrifugal parts [N m], shape (T, M, N)."""

    def torque(self, ddq: Array) -> Array:
        """What accelerations `ddq` (T, M, N) take, link side [N m]."""
        return np.matmul(self.mass, ddq[..., None])[..., 0] + self.bias


def link_terms(arm: RigidArm, q: Array, dq: Array, dt: float) -> LinkTerms:
    """Terms of the links of an arm at positions `q` [rad], speeds `dq`, (T, M, N), link side, `dt` [s] apart."""
    shape = q.shape
    every = max(1, round(_PERIOD / dt))
    places = np.unique(np.append(np.arange(0, shape[0], every), shape[0] - 1))
    coarse_q, coarse_dq = (x[places].reshape(-1, shape[-1]) for x in (q, dq))
    still = np.zeros_like(coarse_q)
    mass = arm.mass_matrix(coarse_q).reshape(len(places), *shape[1:], shape[-1])
    bias = arm.inverse_dynamics(coarse_q, coarse_dq, still, gravity=True) + arm.spring_torque(coarse_q)
    bias = bias.reshape(len(places), *shape[1:])
    if every == 1 or len(places) < 2:
        return LinkTerms(mass=mass, bias=bias)
    samples = np.arange(shape[0])
    return LinkTerms(mass=CubicSpline(places, mass)(samples), bias=CubicSpline(places, bias)(samples))
