"""LuGre friction, motor side, its share behind the elasticity, and slip elements, the memory of presliding."""

from dataclasses import dataclass, fields
from functools import cached_property
from typing import Self

import numpy as np

from ffgym.core.errors import FFGymError, check_shape
from ffgym.core.types import Array, IntArray


@dataclass(frozen=True, kw_only=True, eq=False)
class LuGreParameters:
    r"""Parameters of the LuGre model, motor side, one entry per joint.

    .. math::
        \dot z = v - \sigma_0 \frac{|v|}{g(v)} z, \quad
        g(v) = f_c + (f_s - f_c) e^{-(v / v_s)^2}, \quad
        \tau_f = \sigma_0 z + \sigma_1 \dot z + f_v v

    Raises:
        FFGymError: if a parameter is missing a joint, negative, or `static` is below `coulomb`.

    Reference:
        Canudas de Wit, Olsson, Astrom, Lischinsky (1995), IEEE TAC 40(3), eqs. (3)-(5); thesis (2.7)-(2.9).
    """

    coulomb: Array
    """Coulomb torque f_c [N m], shape (N,), > 0."""
    static: Array
    """Breakaway torque f_s [N m], shape (N,), >= coulomb."""
    viscous: Array
    """Viscous coefficient f_v [N m s/rad], shape (N,), >= 0."""
    stribeck_velocity: Array
    """Stribeck velocity v_s [rad/s], shape (N,), > 0."""
    bristle_stiffness: Array
    """Bristle stiffness sigma_0 [N m/rad], shape (N,), > 0."""
    bristle_damping: Array
    """Bristle damping sigma_1 [N m s/rad], shape (N,), >= 0."""
    arm_share: Array | None = None
    """Share of the friction that acts on the arm, behind the joint's elasticity [1], shape (N,), 0 to 1; None is 0.

    The torques above are those of both parts together. Each part has bristles of its own, on the motor's motion and on
    the link's, with `arm_share` and its complement as factors on all torques. A rigid joint has it all on one side.
    """

    def __post_init__(self) -> None:
        n = np.size(self.coulomb)
        for field in fields(self):
            if field.name == "arm_share":
                continue
            value = check_shape(f"friction {field.name}", np.atleast_1d(getattr(self, field.name)), (n,))
            low_is_open = field.name in ("coulomb", "stribeck_velocity", "bristle_stiffness")
            if np.any(value < 0) or (low_is_open and np.any(value == 0)):
                raise FFGymError(f"friction {field.name} = {value} must be {'> 0' if low_is_open else '>= 0'}.")
            object.__setattr__(self, field.name, value)
        if np.any(self.static < self.coulomb):
            raise FFGymError(f"friction static = {self.static} must be >= coulomb = {self.coulomb} on every joint.")
        if self.arm_share is not None:
            share = check_shape("friction arm_share", np.atleast_1d(self.arm_share), (n,))
            if np.any(share < 0) or np.any(share > 1):
                raise FFGymError(f"friction arm_share = {share} must be from 0 to 1, the part of friction on the arm.")
            # a share of 0 is no share: one description of one robot
            object.__setattr__(self, "arm_share", share if np.any(share) else None)

    @property
    def n_joints(self) -> int:
        """Number of joints N."""
        return int(self.coulomb.size)

    def scale(self, **factors: float | Array) -> Self:
        """Return a copy with the named parameters multiplied by `factors` (numbers or shape (N,))."""
        names = [f.name for f in fields(self) if f.name != "arm_share"]
        values = {name: getattr(self, name) * factors.pop(name, 1.0) for name in names}
        if factors:
            raise FFGymError(f"Unknown friction parameters {sorted(factors)}. Available: {sorted(values)}.")
        return type(self)(**values, arm_share=self.arm_share)

    def select(self, joints: IntArray) -> Self:
        """Return the friction of some joints, by their indices."""
        return type(self)(**{f.name: getattr(self, f.name)[joints] for f in fields(self) if f.name != "arm_share"})

    def stribeck_level(self, dq: Array) -> Array:
        """Steady-state friction level g(v) [N m] without viscous part, >= coulomb; same shape as `dq` [rad/s]."""
        return stribeck_level(dq, self.coulomb, self.static, self.stribeck_velocity)

    def bristle_rate(self, z: Array, dq: Array) -> Array:
        """Rate of the bristle deflection dz/dt [rad/s] at deflection `z` [rad] and motor speed `dq` [rad/s]."""
        return dq - self.bristle_stiffness * np.abs(dq) / self.stribeck_level(dq) * z

    def bristle_rate_slopes(self, z: Array, dq: Array) -> tuple[Array, Array]:
        """Partial derivatives of `bristle_rate` by `dq` [1] and `z` [1/s]; the mean of both sides where `dq` is 0."""
        level, stiffness = self.stribeck_level(dq), self.bristle_stiffness
        level_slope = -2 * dq / self.stribeck_velocity**2 * (level - self.coulomb)
        by_dq = 1 - stiffness * z * (np.sign(dq) - np.abs(dq) * level_slope / level) / level
        return by_dq, -stiffness * np.abs(dq) / level

    def torque(self, z: Array, dq: Array) -> Array:
        """Friction torque [N m] at bristle deflection `z` [rad] and motor speed `dq` [rad/s]; opposes the motion."""
        return self.bristle_stiffness * z + self.bristle_damping * self.bristle_rate(z, dq) + self.viscous * dq

    def steady_torque(self, dq: Array) -> Array:
        """Friction torque [N m] at constant speed `dq` [rad/s], thesis (2.10)."""
        return self.stribeck_level(dq) * np.sign(dq) + self.viscous * dq

    def bend_bristles(self, z: Array, mean_dq: Array, dq: Array, dt: float) -> "BentBristles":
        r"""Bend bristles for `dt` [s] at `mean_dq`, exactly for that speed, to where the motor has the speed `dq`.

        Slopes are those by `dq`, of which `mean_dq` is a half and the speed before the other, in presliding and in
        sliding alike; that of the Stribeck curve is left out, which may make friction fall.

        Args:
            z: bristle deflection before [rad].
            mean_dq: mean motor speed on the way [rad/s].
            dq: motor speed at its end [rad/s].
            dt: time of the way [s].
        """
        stiffness, damping, coulomb, peak, per_velocity, rubbing = self._numbers_of(dq.shape)
        # deflection in steady sliding, and the way to it that is left
        bent = mean_dq * per_velocity
        bent = coulomb + peak * np.exp(-bent * bent)
        ahead = np.copysign(bent, mean_dq)
        left = np.exp(-dt * mean_dq / ahead) * (z - ahead)
        bristle, slope = ahead + left, -0.5 * dt * left / ahead
        # damping sees the rate at the end of the way
        ahead = np.copysign(bent, dq)
        stiff = stiffness - damping * dq / ahead
        torque_slope = stiff * slope + rubbing - damping * bristle / ahead
        return BentBristles(
            bristle=bristle,
            torque=stiff * bristle + rubbing * dq,
            bristle_slope=slope,
            torque_slope=np.maximum(torque_slope, 0.0, out=torque_slope),
        )

    def _numbers_of(self, shape: tuple[int, ...]) -> Array:
        """Numbers by which bristles bend, each as an array of a shape (..., N), which is faster than one per joint.

        Stiffness and damping; deflections in sliding and beyond that at rest [rad], one over the Stribeck velocity, and
        all damping.
        """
        if shape not in self._known_numbers:
            stiffness, damping, coulomb = self.bristle_stiffness, self.bristle_damping, self.coulomb
            bent, peak = coulomb / stiffness, (self.static - coulomb) / stiffness
            each = (stiffness, damping, bent, peak, 1 / self.stribeck_velocity, damping + self.viscous)
            self._known_numbers[shape] = np.array([np.broadcast_to(values, shape) for values in each], order="C")
        return self._known_numbers[shape]

    @cached_property
    def _known_numbers(self) -> dict[tuple[int, ...], Array]:
        return {}

    def exact_bristle_factors(self, dq: Array, dt: float | Array) -> tuple[Array, Array]:
        r"""Exact solution of the bristle equation over `dt` [s] at frozen motor speed `dq` [rad/s].

        The equation is linear in z for a frozen speed, so that with :math:`a = \sigma_0 |v| / g(v)`

        .. math:: z_+ = e^{-a h} z + \frac{1 - e^{-a h}}{a} v

        which is stable at every step, where forward Euler needs h < 2 / a.

        Returns:
            Factors (keep, gain) of z_next = keep * z + gain, shapes as `dq`; keep [1], gain [rad].
        """
        decay = self.bristle_stiffness * np.abs(dq) / self.stribeck_level(dq) * dt
        moving = decay > 0
        share = np.where(moving, -np.expm1(-decay) / np.where(moving, decay, 1.0), 1.0)
        return np.exp(-decay), share * dt * dq


@dataclass(slots=True, kw_only=True, eq=False)
class BentBristles:
    """Bristles after a way, motor side, and what a higher speed at its end would change."""

    bristle: Array
    """Deflection [rad]."""
    torque: Array
    """Friction torque, viscous part included; opposes the motion [N m]."""
    bristle_slope: Array
    """Change of the deflection by the speed [s]."""
    torque_slope: Array
    """Change of the torque by the speed [N m s/rad], >= 0."""


def stribeck_level(dq: Array, coulomb: Array, static: Array, stribeck_velocity: Array) -> Array:
    """Compute the steady-state friction level g(v) [N m], without viscous part, at motor speed `dq` [rad/s]."""
    return coulomb + (static - coulomb) * stribeck_decay(dq, stribeck_velocity)


def stribeck_decay(dq: Array, stribeck_velocity: float | Array, exponent: float | Array = 2) -> Array:
    """Compute the share of the breakaway peak that is left at motor speed `dq` [rad/s]: 1 at rest, 1/e at v_s."""
    return np.exp(-(np.abs(dq / stribeck_velocity) ** exponent))


WIDTHS = np.array([0.002, 0.004, 0.008, 0.016, 0.032])
"""Motor travel [rad] after which an element slips. Chosen: octaves around 8 mrad, over which the bristles of the
built-in robots bend; five cover presliding between a quarter and four times of that, and which of them matter is
learned."""


def advance_slip(slip: Array, dq: Array, next_dq: Array, dt: float, widths: Array = WIDTHS) -> Array:
    r"""Elements (..., N, W), from -1 to 1, a step of `dt` [s] later; the motor speed runs straight between (..., N).

    Each is a spring that slips beyond its width w, the stop operator of Prandtl's model of presliding friction:

    .. math:: s_+ = \min(\max(s + \Delta q / w, -1), 1)

    A weighted sum of them is a hysteresis loop with memory of the loops within it (Krasnosel'skii & Pokrovskii 1989,
    "Systems with Hysteresis").
    """
    # np.clip takes three times as long in a loop
    return np.minimum(np.maximum(slip + _steps(dq, next_dq, dt, widths), -1.0), 1.0)


def slip_along(motor_dq: Array, dt: float, widths: Array = WIDTHS) -> Array:
    """Elements along motor speeds (T, N) [rad/s] sampled every `dt` [s], shape (T, N, W); relaxed at the start."""
    start = np.zeros((*motor_dq.shape[1:], len(widths)))
    return np.concatenate([start[None], _slip_along(start, _steps(motor_dq[:-1], motor_dq[1:], dt, widths))])


def advance_slip_along(dq: Array, dt: float, widths: Array) -> Array:
    """Elements after each of T steps at speeds (T, ..., N), relaxed before; as `advance_slip` step by step."""
    steps = _steps(dq, dq, dt, widths)
    return _slip_along(np.zeros(steps.shape[1:]), steps)


def _slip_along(slip: Array, steps: Array) -> Array:
    """Elements after each of the `steps` (T, ..., W), from `slip` on."""
    found = steps.copy()
    low, high = np.full(slip.shape, -1.0), np.full(slip.shape, 1.0)  # arrays, as numbers take twice as long in a loop
    for now in found:
        now += slip
        np.maximum(now, low, out=now)
        np.minimum(now, high, out=now)
        slip = now
    return found


def _steps(dq: Array, next_dq: Array, dt: float, widths: Array) -> Array:
    """Travel in widths, (..., N, W)."""
    travel = 0.5 * dt * (dq + next_dq)
    steps: Array = travel[..., None] / widths
    return steps
