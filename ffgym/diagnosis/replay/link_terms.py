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

from ffgym.core.types import Array, IntArray
from ffgym.diagnosis.replay.recursions import along, places_of
from ffgym.robot import RigidArm

_PERIOD = 0.004
"""Time between evaluations [s]; chosen: the usual control period, in which no pose changes by much."""

_SLOW = 0.016
"""Time between evaluations of what bending adds [s]; chosen: it is a correction, known to a hundredth so."""

_SLOWER = 0.032
"""Time between evaluations of what bending adds with other masses [s]; chosen: it is the change of a correction."""

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
    bent: Array | None = None
    """About how joints bend [rad], (T, M, N): where poses are beside those of the motors; None is not at all."""

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
    places = places_of(len(q), max(1, round(_SLOW / dt)))
    return _between(places, *_slopes(arm, q, dq, ddq, places, joints))


def _slopes(arm: RigidArm, q: Array, dq: Array, ddq: Array, places: IntArray, joints: IntArray) -> tuple[Array, Array]:
    """What bending adds per rate and per deflection of `joints` at P places, (P, M, N, N) each."""
    shape, n = (len(places), *q.shape[1:], q.shape[-1]), q.shape[-1]
    at = [x[places].reshape(-1, n) for x in (q, dq, ddq)]
    rate, place = np.zeros((2, len(at[0]), n, n))
    plain = _torque(arm, *at)
    for j in joints.tolist():
        step = np.zeros(n)
        step[j] = _STEP
        place[..., j] = (_torque(arm, at[0] + step, at[1], at[2]) - plain) / _STEP
        rate[..., j] = (_torque(arm, at[0], at[1] + step, at[2]) - plain) / _STEP
    return rate.reshape(shape), place.reshape(shape)


def _between(places: IntArray, rate: Array, place: Array) -> Bending:
    """What bending adds at all samples by what it adds at `places`, (P, M, N, N) each."""
    return Bending(rate=along(places, rate), place=along(places, place))


def _torque(arm: RigidArm, q: Array, dq: Array, ddq: Array) -> Array:
    """Torque of links at poses (P, N), link side [N m]."""
    return arm.inverse_dynamics(q, dq, ddq, gravity=True) + arm.spring_torque(q)


def link_terms(arm: RigidArm, q: Array, dq: Array, dt: float) -> LinkTerms:
    """Terms of the links of an arm at positions `q` [rad], speeds `dq`, (T, M, N), link side, `dt` [s] apart."""
    places = places_of(len(q), max(1, round(_PERIOD / dt)))
    mass, bias = _terms(arm, q, dq, places)
    return LinkTerms(mass=along(places, mass), bias=along(places, bias))


def _terms(arm: RigidArm, q: Array, dq: Array, places: IntArray) -> tuple[Array, Array]:
    """M (P, M, N, N) and h (P, M, N) at P places of a motion."""
    shape = (len(places), *q.shape[1:])
    there, speed = (x[places].reshape(-1, shape[-1]) for x in (q, dq))
    mass, bias = arm.equations_of_motion(there, speed, gravity=True)
    return mass.reshape(*shape, shape[-1]), (bias + arm.spring_torque(there)).reshape(shape)


def terms_beside(
    arm: RigidArm, known: LinkTerms, q: Array, dq: Array, ddq: Array, dt: float, joints: IntArray
) -> LinkTerms:
    """Terms of an arm whose masses and inertias are others than those of an arm whose terms are `known`.

    What they differ by is evaluated where the other arm was, and a quarter as often: it changes as slowly, and is a
    small part of the whole.

    Args:
        arm: whose terms are asked for.
        known: of the other arm, along the same motion.
        q: positions of the motors [rad], (T, M, N), link side.
        dq: speeds, likewise.
        ddq: accelerations, likewise.
        dt: sample time [s].
        joints: that bend, of both arms.
    """
    bent = np.zeros_like(q) if known.bent is None else known.bent
    there, slow = q + bent, places_of(len(q), max(1, round(_SLOW / dt)))
    mass, bias = _terms(arm, there, dq, slow)
    bending, more_by_place = None, 0.0
    if known.bending is not None:
        slower = places_of(len(q), max(1, round(_SLOWER / dt)))
        rate, place = _slopes(arm, there, dq, ddq, slower, joints)
        bending = _between(slower, rate - known.bending.rate[slower], place - known.bending.place[slower])
        more_by_place = np.matmul(bending.place, bent[..., None])[..., 0]
        np.add(bending.rate, known.bending.rate, out=bending.rate)
        np.add(bending.place, known.bending.place, out=bending.place)
        bias = bias - np.matmul(known.bending.place[slow], bent[slow][..., None])[..., 0]
    return LinkTerms(
        mass=known.mass + along(slow, mass - known.mass[slow]),
        bias=known.bias + along(slow, bias - known.bias[slow]) - more_by_place,
        bending=bending,
        bent=known.bent,
    )
