"""What the links ask for along measured motions: inertia matrices, and the torque that a motion without springs takes.

MuJoCo evaluates them at every n-th sample, fast enough to follow poses, and between those they are interpolated; the
accelerations, which change fast, are multiplied in at every sample.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from ffgym.robot import RigidArm
from ffgym.types import Array

_PERIOD = 0.004
"""Time between evaluations [s]; chosen: the usual control period, in which no pose changes by much."""

_POINTS = 4
"""Evaluations about a sample that its terms are interpolated from: those of a cubic."""


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
    if len(places) < _POINTS:
        places = np.arange(shape[0])
    coarse_q, coarse_dq = (x[places].reshape(-1, shape[-1]) for x in (q, dq))
    mass, bias = arm.equations_of_motion(coarse_q, coarse_dq, gravity=True)
    bias = bias + arm.spring_torque(coarse_q)
    mass, bias = mass.reshape(len(places), -1), bias.reshape(len(places), -1)
    if len(places) < shape[0]:
        between = _between(places)
        mass, bias = between @ mass, between @ bias
    return LinkTerms(mass=mass.reshape(*shape, shape[-1]), bias=bias.reshape(shape))


def _between(places: Array) -> csr_array:
    """Weights of values at P `places`, sample numbers, in all T samples up to the last of them, shape (T, P).

    Each is on the cubic through the four places around it (Lagrange): as near as a spline of values that vary this
    slowly, and thirty times as fast.
    """
    samples = np.arange(places[-1] + 1)
    first = np.clip(np.searchsorted(places, samples, side="right") - 2, 0, len(places) - _POINTS)
    near = first[:, None] + np.arange(_POINTS)
    x = places[near]
    weights = np.ones(near.shape)
    for a in range(_POINTS):
        for b in set(range(_POINTS)) - {a}:
            weights[:, a] *= (samples - x[:, b]) / (x[:, a] - x[:, b])
    ends = np.arange(0, near.size + 1, _POINTS)
    return csr_array((weights.ravel(), near.ravel(), ends), shape=(len(samples), len(places)))
