"""Set-points at every physics step, which the drive makes of samples that arrive every control step.

Positions and speeds are joined by cubic Hermite pieces, torques by straight lines, as the fine interpolator of a drive
does. A torque that is computed for sample k + 1 is thus reached at t[k + 1]. (Chosen; the thesis sends samples at 4 ms
and logs at 0.5 ms, and does not describe the interpolation in its drive.)
"""

from dataclasses import dataclass

import numpy as np

from ffgym.core.errors import check_shape
from ffgym.core.types import Array, IntArray
from ffgym.robot.parts import Servo


@dataclass(frozen=True, kw_only=True, eq=False)
class Setpoints:
    """Samples sent to the drives of B robots, motor side; each array has shape (B, T, N)."""

    position: Array
    """[rad]."""
    velocity: Array
    """[rad/s]."""
    torque: Array
    """Sum of all feed-forward torques [N m]."""
    dt: float
    """Time between samples [s]."""

    def __post_init__(self) -> None:
        check_shape("set-point position", self.position, (None, None, None))
        for name in ("velocity", "torque"):
            check_shape(f"set-point {name}", getattr(self, name), self.position.shape)

    def between(
        self, robots: IntArray, start: int, stop: int, fractions: Array, out: tuple[Array, Array, Array] | None = None
    ) -> tuple[Array, Array, Array]:
        """Interpolate position, velocity and torque within control steps `start` to `stop` - 1.

        Args:
            robots: indices of the robots, shape (B',).
            start: first control step; step k runs from sample k to sample k + 1.
            stop: control step after the last.
            fractions: points within each step, 0 at its start and 1 at its end, shape (S,).
            out: arrays to write into, of the shape that is returned.

        Returns:
            Three arrays of shape (B', stop - start, S, N). All arithmetic is elementwise, so that a result does not
            depend on the number of robots or steps that are computed together.
        """
        if out is None:
            shape = (len(robots), stop - start, len(fractions), self.position.shape[2])
            out = (np.empty(shape), np.empty(shape), np.empty(shape))
        p, v, u = (part[robots, start : stop + 1] for part in (self.position, self.velocity, self.torque))
        interpolate_motion(p, v, self.dt, fractions, out[:2])
        interpolate_torque(u, fractions, out[2])
        return out

    def at_rows(self, rows_per_step: int) -> tuple[Array, Array, Array]:
        """Interpolate all three at `rows_per_step` points of each step and at the last sample, (B, R, N) each."""
        robots, steps, n = self.position.shape
        fractions = np.arange(rows_per_step) / rows_per_step
        parts = self.between(np.arange(robots), 0, steps - 1, fractions)
        lasts = (self.position, self.velocity, self.torque)
        position, velocity, torque = (
            np.concatenate([part.reshape(robots, -1, n), last[:, -1:]], axis=1)
            for part, last in zip(parts, lasts, strict=True)
        )
        return position, velocity, torque


def interpolate_motion(position: Array, velocity: Array, dt: float, fractions: Array, out: tuple[Array, Array]) -> None:
    """Write position and velocity at `fractions` (S,) of each step between samples (B, T, N) into `out`.

    Samples are `dt` [s] apart, in [rad] and [rad/s]; those in `out` have shape (B, T - 1, S, N).
    """
    p0, p1 = _ends(position)
    v0, v1 = _ends(velocity)
    rise = p1 - p0
    # coefficients of the cubic in the share of the step, from values and slopes at both ends
    square, cube = 3 * rise - dt * (2 * v0 + v1), dt * (v0 + v1) - 2 * rise
    _horner(out[0], fractions, (cube, square, dt * v0, p0))
    _horner(out[1], fractions, (3 / dt * cube, 2 / dt * square, v0))


def interpolate_torque(torque: Array, fractions: Array, out: Array) -> None:
    """Write the torque at `fractions` (S,) of each step between samples (B, T, N) into `out` (B, T - 1, S, N)."""
    join_torques(*_ends(torque), fractions, out.swapaxes(-1, -2))


def join_torques(start: Array, end: Array, fractions: Array, out: Array) -> None:
    """Write torques at `fractions` (S,) of straight lines from `start` to `end` (..., N) into `out` (..., N, S)."""
    rise = (end - start)[..., None] * fractions
    np.add(rise, start[..., None], out=out)


def torque_at_rows(torque: Array, rows_per_step: int) -> Array:
    """Interpolate a torque (T, N) at `rows_per_step` points of each control step and at the last sample."""
    fractions = np.arange(rows_per_step) / rows_per_step
    between = np.empty((1, len(torque) - 1, rows_per_step, torque.shape[1]))
    interpolate_torque(torque[None], fractions, between)
    return np.concatenate([between.reshape(-1, torque.shape[1]), torque[-1:]])


def _horner(out: Array, x: Array, coefficients: tuple[Array, ...]) -> None:
    """Write the polynomial in `x` (S,) with coefficients (B, T, N), highest power first, into `out` (B, T, S, N).

    Points are the last axis on the way, which is far faster than N joints in that place.
    """
    value = coefficients[0][..., None] * x
    for coefficient in coefficients[1:-1]:
        value += coefficient[..., None]
        value *= x
    np.add(value, coefficients[-1][..., None], out=out.swapaxes(-1, -2))


def _ends(samples: Array) -> tuple[Array, Array]:
    """Return values at the start and the end of each step."""
    return samples[:, :-1], samples[:, 1:]


@dataclass(slots=True, kw_only=True, eq=False)
class ServoTorque:
    """Feedback torque and its integral part, motor side [N m], any shape (..., N)."""

    u_fb: Array
    """Whole feedback torque, u_c of the thesis."""
    u_i: Array
    """Integral part of the feedback torque."""

    @property
    def u_p(self) -> Array:
        """Feedback torque without its integral part, u_p = u_fb - u_i: the learning signal of chapter 5."""
        return self.u_fb - self.u_i


def servo_torque(servo: Servo, error: Array, error_rate: Array, integral: Array) -> ServoTorque:
    r"""Compute the feedback torque before the drive's limit, motor side.

    .. math:: u_c = K_p e + K_v \dot e + u_I, \quad u_I = K_i \int e \, dt

    Args:
        servo: gains.
        error: position error e = reference - measured [rad], shape (..., N).
        error_rate: speed error [rad/s], shape (..., N).
        integral: integral of the position error [rad s], shape (..., N).
    """
    u_i = servo.integral_gain * integral
    return ServoTorque(u_fb=servo.position_gain * error + servo.velocity_gain * error_rate + u_i, u_i=u_i)
