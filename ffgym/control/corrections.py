r"""Corrections of set-points that make a known servo give the torque of a feed-forward law, and their limits.

A servo that follows set-points gives the torque u of a law if these move by the correction c with

.. math:: K_v \dot c + K_p c + K_i \int c \, dt = u

(motor side): the inverse of the servo, which is stable for positive gains. It is solved by the trapezoidal rule, so
that the torque of each control step is right on average. A drive that gets positions alone takes speeds from their
backward differences; on circles of the thesis that loses nothing against torques (docs/deployment/setpoints.md).
"""

from dataclasses import dataclass
from typing import final

import numpy as np

from ffgym.core.errors import FFGymError, check_number, check_shape
from ffgym.core.types import Array
from ffgym.robot.parts import Servo


def check_invertible(servo: Servo) -> None:
    """Check that corrections of set-points give any torque: position and velocity gains must be positive.

    Raises:
        FFGymError: if one is not.
    """
    for name in ("position_gain", "velocity_gain"):
        if np.any(getattr(servo, name) <= 0):
            raise FFGymError(
                f"servo.{name} = {getattr(servo, name).tolist()} must be > 0 on every joint: corrections of set-points "
                f"act through it. Send torques to this robot, or describe its servo."
            )


def next_correction(
    servo: Servo, torque: Array, following_torque: Array, correction: Array, integral: Array
) -> tuple[Array, Array]:
    """Compute the correction of the next sample, elementwise over leading axes (..., N), motor side.

    Args:
        servo: gains, and the time between samples.
        torque: torque to give at the present sample [N m].
        following_torque: torque to give at the next sample [N m].
        correction: present correction [rad].
        integral: integral of the corrections so far [rad s].

    Returns:
        The next correction [rad] and the integral up to it [rad s].
    """
    dt = servo.control_dt
    held, gain = _hold(servo, correction, integral)
    following = correction + dt * ((torque + following_torque) / 2 - held) / gain
    return following, integral + dt / 2 * (correction + following)


def _hold(servo: Servo, correction: Array, integral: Array) -> tuple[Array, Array]:
    """Compute the mean torque that a servo gives in a step if the correction stays, and what its mean speed adds to it.

    By the trapezoidal rule, elementwise.

    Returns:
        Torque [N m] and torque per mean speed of the correction [N m s/rad].
    """
    dt = servo.control_dt
    held = servo.position_gain * correction + servo.integral_gain * (integral + dt / 2 * correction)
    return held, servo.velocity_gain + servo.position_gain * dt / 2 + servo.integral_gain * dt**2 / 4


def invert_servo(servo: Servo, torque: Array, inertia: Array | None = None) -> Array:
    r"""Compute the corrections by which a servo gives a torque, motor side [rad], shape (T, N); zero at first.

    A controller that computes its rigid feed-forward from corrected set-points gives :math:`M \ddot c` beside the
    servo's torque, with the inertia M of the arm as motors feel it.

    Args:
        servo: gains, and the time between samples.
        torque: torque to give, motor side [N m], shape (T, N).
        inertia: M at every sample, motor side [kg m^2], shape (T, N, N); None for a controller whose feed-forward does
            not see the corrections.

    Raises:
        FFGymError: if a gain is not positive.
    """
    check_invertible(servo)
    corrections, integral = np.zeros_like(torque), np.zeros(torque.shape[1])
    speed = np.zeros(torque.shape[1])
    for k in range(len(torque) - 1):
        if inertia is None:
            corrections[k + 1], integral = next_correction(servo, torque[k], torque[k + 1], corrections[k], integral)
            continue
        # mean speed of the step, with what the feed-forward adds for its change
        dt = servo.control_dt
        held, gain = _hold(servo, corrections[k], integral)
        moved = 2 / dt * (inertia[k] + inertia[k + 1]) / 2
        mean = np.linalg.solve(moved + np.diag(gain), (torque[k] + torque[k + 1]) / 2 - held + moved @ speed)
        corrections[k + 1], speed = corrections[k] + dt * mean, 2 * mean - speed
        integral = integral + dt / 2 * (corrections[k] + corrections[k + 1])
    return corrections


def difference_speeds(position: Array, dt: float) -> Array:
    """Compute speeds as a drive does that gets positions (T, N) alone: backward differences, zero at first."""
    return np.diff(position, axis=0, prepend=position[:1]) / dt


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class CorrectionLimits:
    """Limits of a correction, one number per joint; inf is no limit. Units are those of the correction."""

    size: Array
    """Largest correction [rad], shape (N,)."""
    rate: Array
    """Fastest change [rad/s], shape (N,)."""
    acceleration: Array
    """Fastest change of the rate [rad/s^2], shape (N,)."""

    def __post_init__(self) -> None:
        for name in ("size", "rate", "acceleration"):
            value = np.asarray(getattr(self, name), dtype=np.float64)
            if value.ndim != 1 or not np.all(value > 0):
                raise FFGymError(f"{name} of correction limits = {value.tolist()} must be > 0, one number per joint.")

    @classmethod
    def even(
        cls, n: int, *, size: float = np.inf, rate: float = np.inf, acceleration: float = np.inf
    ) -> "CorrectionLimits":
        """Make limits that are the same for all of `n` joints."""
        return cls(size=np.full(n, size), rate=np.full(n, rate), acceleration=np.full(n, acceleration))

    def find_excess(self, position: Array, dt: float) -> dict[str, Array]:
        """Compute how far each limit is exceeded by corrections (T, N), as a share of it, shape (N,); 0 is within."""
        speed = np.diff(position, axis=0) / dt
        change = np.diff(speed, axis=0, prepend=np.zeros((1, position.shape[1]))) / dt
        most = {"size": position, "rate": speed, "acceleration": change}
        largest = {name: np.abs(values).max(axis=0, initial=0.0) for name, values in most.items()}
        return {name: np.maximum(values / getattr(self, name) - 1, 0.0) for name, values in largest.items()}

    def step(self, wanted: Array, position: Array, speed: Array, dt: float) -> tuple[Array, Array]:
        """Move a correction towards a wanted one as far as the limits allow; elementwise over leading axes.

        The speed never exceeds that from which the correction can still stop at the largest size, so that a correction
        within its limits stays there.

        Args:
            wanted: wanted next correction, shape (..., N).
            position: present correction, shape (..., N).
            speed: its change in the last step, per second, shape (..., N).
            dt: time of a step [s].

        Returns:
            The next correction, and its change per second on the way there.
        """
        goal = np.clip(wanted, -self.size, self.size)
        # speed that reaches the goal, or from which the correction can still stop there
        distance = goal - position
        most = np.minimum(np.minimum(np.abs(distance) / dt, self.rate), self._stopping_speed(np.abs(distance), dt))
        # changed no faster than allowed, and never beyond what stops at the largest size
        slowest, fastest = speed - self.acceleration * dt, speed + self.acceleration * dt
        following = np.clip(np.sign(distance) * most, slowest, fastest)
        up, down = (self._stopping_speed(np.maximum(self.size - s * position, 0.0), dt) for s in (1, -1))
        following = np.clip(following, -down, up)
        return position + dt * following, following

    def _stopping_speed(self, distance: Array, dt: float) -> Array:
        """Compute the largest speed of a step from which steps of braking still end within a distance.

        Steps of v, v - a dt, v - 2 a dt, ... cover at most (v + a dt / 2)^2 / (2 a); a last step may cover all that is
        left, if braking ends there.
        """
        change = self.acceleration * dt
        finite = np.isfinite(change)
        braking = np.where(finite, self.acceleration, 1.0)
        rolling = np.sqrt(2 * braking * distance) - braking * dt / 2
        last = distance / dt
        return np.where(finite, np.minimum(np.maximum(rolling, np.minimum(last, change)), last), last)


def limit_correction(limits: CorrectionLimits, wanted: Array, dt: float) -> Array:
    """Follow wanted corrections (T, N), zero at first, within limits; equal to them where they are within.

    Where limits are exceeded, the correction follows as fast as they allow.

    Raises:
        FFGymError: if a correction is no number, there is another number of joints than of limits, or `dt` is not > 0.
    """
    wanted = check_shape("wanted corrections", wanted, (None, len(limits.size)))
    check_number("dt", dt, unit="s", low=0.0, open_low=True)
    if all(not excess.any() for excess in limits.find_excess(wanted, dt).values()):
        return wanted.copy()
    position = np.zeros_like(wanted)
    speed = np.zeros(wanted.shape[1])
    for k in range(1, len(wanted)):
        position[k], speed = limits.step(wanted[k], position[k - 1], speed, dt)
    return position
