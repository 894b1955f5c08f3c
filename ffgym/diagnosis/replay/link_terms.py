r"""Equations of motion of the links along measured motions: inertia matrices, and torque of a motion without springs.

Where joints bend, the links move a little otherwise than the motors. To first order they then ask for

.. math:: M \ddot\delta + \frac{\partial h}{\partial \dot q} \dot\delta +
    \frac{\partial (M \ddot q + h)}{\partial q} \delta

more: while a joint swings, Coriolis torques couple and damp it by a tenth of what its inertia takes.

MuJoCo evaluates them at every n-th sample, fast enough to follow poses, and between those they are interpolated; the
accelerations, which change fast, are multiplied in at every sample.
"""

from dataclasses import dataclass

import numpy as np

from ffgym.diagnosis.replay.interpolation import cubics, places_of
from ffgym.robot import RigidArm
from ffgym.types import Array, IntArray

_PERIOD = 0.004
"""Time between evaluations [s]; chosen: the usual control period, in which no pose changes by much."""

_SLOW = 0.016
"""Time between evaluations of what bending adds [s]; chosen: it is a correction, known to a hundredth so."""

_STEP = 1e-4
"""Change of an angle [rad], or a speed [rad/s], over which terms are differentiated; chosen: some springs' bending."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LinkTerms:
    r"""Terms of :math:`M(q) \ddot q + h(q, \dot q)` along M motions of T samples, link side."""

    mass: Array
    """M(q) [kg m^2], shape (T, M, N, N), without rotors."""
    bias: Array
    """h: gravity, springs between links, Coriolis and centrifugal parts [N m], shape (T, M, N); where joints bend, as
    it would be if they did not."""
    bending: "Bending | None" = None
    """What is added where joints bend, beside inertia; None is nothing."""

    def torque(self, ddq: Array) -> Array:
        """Torque that accelerations `ddq` (T, M, N) take, link side [N m]."""
        return np.matmul(self.mass, ddq[..., None])[..., 0] + self.bias


@dataclass(frozen=True, kw_only=True, eq=False)
class Bending:
    """Torque of links beside inertia where joints bend, per bending of the last axis; (T, M, N, N)."""

    rate: Array
    """Per rate of the deflection [N m s/rad]."""
    place: Array
    """Per deflection [N m/rad]."""


def bending_of(arm: RigidArm, q: Array, dq: Array, ddq: Array, dt: float, joints: IntArray) -> Bending:
    """Linearise what bending of `joints` adds about `q`, speeds `dq` and accelerations `ddq`, (T, M, N), link side."""
    shape, n = q.shape, q.shape[-1]
    places = places_of(shape[0], max(1, round(_SLOW / dt)))
    at = [x[places].reshape(-1, n) for x in (q, dq, ddq)]
    rate, place = np.zeros((2, len(at[0]), n, n))
    plain = _torque(arm, *at)
    for j in joints.tolist():
        step = np.zeros(n)
        step[j] = _STEP
        place[..., j] = (_torque(arm, at[0] + step, at[1], at[2]) - plain) / _STEP
        rate[..., j] = (_torque(arm, at[0], at[1] + step, at[2]) - plain) / _STEP
    rate, place = (x.reshape(len(places), -1) for x in (rate, place))
    if len(places) < shape[0]:
        between = cubics(places)
        rate, place = between @ rate, between @ place
    return Bending(rate=rate.reshape(*shape, n), place=place.reshape(*shape, n))


def _torque(arm: RigidArm, q: Array, dq: Array, ddq: Array) -> Array:
    """Torque of links at poses (P, N), link side [N m]."""
    return arm.inverse_dynamics(q, dq, ddq, gravity=True) + arm.spring_torque(q)


def link_terms(arm: RigidArm, q: Array, dq: Array, dt: float) -> LinkTerms:
    """Terms of the links of an arm at positions `q` [rad], speeds `dq`, (T, M, N), link side, `dt` [s] apart."""
    shape = q.shape
    places = places_of(shape[0], max(1, round(_PERIOD / dt)))
    coarse_q, coarse_dq = (x[places].reshape(-1, shape[-1]) for x in (q, dq))
    mass, bias = arm.equations_of_motion(coarse_q, coarse_dq, gravity=True)
    bias = bias + arm.spring_torque(coarse_q)
    mass, bias = mass.reshape(len(places), -1), bias.reshape(len(places), -1)
    if len(places) < shape[0]:
        between = cubics(places)
        mass, bias = between @ mass, between @ bias
    return LinkTerms(mass=mass.reshape(*shape, shape[-1]), bias=bias.reshape(shape))
