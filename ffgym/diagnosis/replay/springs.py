r"""Deflections of elastic joints whose motors move as measured: the arm as a system of springs that is driven.

.. math:: M(q) \ddot\delta + d \dot\delta + K \delta = p

with the mass matrix along the measured motion. Newmark's method of constant average acceleration, stable at any step: a
resonance above the sample rate follows its load, as it should.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ffgym.errors import FFGymError
from ffgym.types import Array, IntArray

_FIRST_REACH = 1e-4
"""Deflection [rad] beyond that of linear springs in which a rest is looked for first; chosen: a third of an
arc minute."""

_DOUBLINGS, _HALVINGS = 12, 50
"""Of that reach, to 0.4 rad, and of the bracket, to less than rounding."""

_MOST = 1.0
"""Deflection [rad] from which on an arm is no longer where it was measured: a thousand times what gearboxes bend."""


class FlownAwayError(FFGymError):
    """An arm whose springs do not hold it: something pushes it away from where its motors are."""


Push = Callable[[int, Array, Array], Array]
"""What acts on the springs at sample k, at deflection and rate (M, N), link side [N m], (M, N)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Deflection:
    """Of links behind their gearboxes, link side, (T, M, N) or (T, M, N, V) each; 0 for rigid joints."""

    angle: Array
    """[rad]."""
    rate: Array
    """[rad/s]."""
    acceleration: Array
    """[rad/s^2]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Springs:
    """Elastic joints along M motions of T samples."""

    mass: Array
    """Shape (T, M, N, N), link side [kg m^2]."""
    stiffness: Array
    """K [N m/rad], shape (N,); inf is rigid."""
    damping: Array
    """d [N m s/rad], shape (N,)."""
    dt: float

    @cached_property
    def elastic(self) -> IntArray:
        """Joints that bend."""
        return np.flatnonzero(np.isfinite(self.stiffness))

    @property
    def finite_stiffness(self) -> Array:
        """K [N m/rad], shape (N,); 1 for rigid joints, which do not bend whatever it is."""
        return np.where(np.isfinite(self.stiffness), self.stiffness, 1.0)

    @cached_property
    def _inverse(self) -> Array:
        """Of M + dt/2 d + dt^2/4 K, shape (T, M, E, E)."""
        e = self.elastic
        inner = self.mass[:, :, e[:, None], e]
        diagonal = self.dt / 2 * self.damping[e] + self.dt**2 / 4 * self.stiffness[e]
        return np.linalg.inv(inner + np.diag(diagonal)).astype(np.float64, copy=False)

    def coarser(self, every: int) -> "Springs":
        """The same springs at every n-th sample."""
        return Springs(mass=self.mass[::every], stiffness=self.stiffness, damping=self.damping, dt=every * self.dt)

    def bent_by(self, torque: Array) -> Deflection:
        """Deflections under `torque` [N m], shape (T, M, N, V), for V loads at once, settled at the first sample."""
        e, dt, shape = self.elastic, self.dt, torque.shape
        angle, rate, acceleration = np.zeros(shape), np.zeros(shape), np.zeros(shape)
        found = Deflection(angle=angle, rate=rate, acceleration=acceleration)
        if not len(e):
            return found
        every = slice(None) if len(e) == shape[2] else e
        load, inverse = torque[:, :, every], self._inverse
        stiffness, damping = self.stiffness[e, None], self.damping[e, None]
        x = load[0] / stiffness
        speed, change = np.zeros_like(x), np.zeros_like(x)
        angle[0][:, every] = x
        for k in range(1, shape[0]):
            x = x + dt * speed + dt**2 / 4 * change
            speed = speed + dt / 2 * change
            change = inverse[k] @ (load[k] - damping * speed - stiffness * x)
            x = x + dt**2 / 4 * change
            speed = speed + dt / 2 * change
            angle[k][:, every], rate[k][:, every], acceleration[k][:, every] = x, speed, change
        return found

    def pushed_by(self, torque: Array, push: Push, start: Array) -> Deflection:
        """Deflections under `torque` (T, M, N) and a `push` that depends on them, from rest at `start` (M, N).

        The push is evaluated where the arm is expected after the step, so that it does not lag behind.

        Raises:
            FlownAwayError: if it pushes the arm away from its springs.
        """
        e, dt, shape = self.elastic, self.dt, torque.shape
        found = Deflection(angle=np.zeros(shape), rate=np.zeros(shape), acceleration=np.zeros(shape))
        inverse, stiffness, damping = self._inverse, self.stiffness[e], self.damping[e]
        found.angle[0] = start
        push(0, start, np.zeros_like(start))
        x, rate, change = start[:, e], np.zeros((shape[1], len(e))), np.zeros((shape[1], len(e)))
        expected, expected_rate = start.copy(), np.zeros_like(start)
        for k in range(1, shape[0]):
            expected[:, e], expected_rate[:, e] = x + dt * rate + dt**2 / 2 * change, rate + dt * change
            load = (torque[k] + push(k, expected, expected_rate))[:, e]
            x = x + dt * rate + dt**2 / 4 * change
            rate = rate + dt / 2 * change
            change = (inverse[k] @ (load - damping * rate - stiffness * x)[..., None])[..., 0]
            x, rate = x + dt**2 / 4 * change, rate + dt / 2 * change
            if not (bent := float(np.max(np.abs(x), initial=0.0))) < _MOST:
                raise FlownAwayError(f"An arm does not stay where its motors are: it bends by {bent:g} rad.")
            found.angle[k][:, e], found.rate[k][:, e], found.acceleration[k][:, e] = x, rate, change
        return found


def resting(pull: Callable[[Array], Array], near: Array) -> Array:
    """Deflections at which `pull`, which grows with the deflection of its own joint, is 0; by bisection, (M, N).

    Backlash and hardening are steeper than a fixed-point iteration bears. In a gap, where nothing pulls, a place in it
    is taken, `near` itself if that is one.
    """
    reach: Array = np.abs(near) + _FIRST_REACH
    low, high = near - reach, near + reach
    for _ in range(_DOUBLINGS):
        low = np.where(pull(low) > 0, low - reach, low)
        high = np.where(pull(high) < 0, high + reach, high)
        reach *= 2
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        value = pull(middle)
        low, high = np.where(value <= 0, middle, low), np.where(value >= 0, middle, high)
    rest: Array = 0.5 * (low + high)
    return rest
