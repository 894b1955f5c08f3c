"""Resolvers that servos read: angles in steps, at the drive's rate, and speeds as their differences (thesis 2.2.1)."""

from collections.abc import Sequence

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.effects import ResolverEffect, ResolverError
from ffgym.robot import RobotDescription


class Resolvers:
    r"""Readings of the resolvers of B robots, which their servos act on until the next reading.

    .. math:: \theta_k = h \, \mathrm{round}(\theta(k T) / h), \quad \omega_k = (\theta_k - \theta_{k-1}) / T

    with steps of h = 2 pi / 2^bits and a period T of `drive.resolver_period`. Robots without a period are not touched.

    Raises:
        FFGymError: if a period is no whole number of physics steps.
    """

    def __init__(self, robots: Sequence[RobotDescription], dt: float) -> None:
        period = np.array([robot.drive.resolver_period for robot in robots])
        self.present = (period > 0)[:, None]
        """Mask of robots whose servos read resolvers, shape (B, 1)."""
        self.all_present = bool(self.present.all())
        """True if all do."""
        self._every = np.maximum(np.round(period / dt), 1.0)[:, None]
        wrong = self.present[:, 0] & (np.abs(self._every[:, 0] * dt - period) > 1e-9)
        if wrong.any():
            raise FFGymError(
                f"drive.resolver_period = {period[wrong][0]} s must be a whole multiple of physics_dt = {dt} s."
            )
        self._period = np.where(self.present, period[:, None], 1.0)
        self._step = np.array([[robot.sensors.resolver_step] for robot in robots])
        shape = (len(robots), robots[0].n_joints)
        self._angle, self._speed = np.zeros(shape), np.zeros(shape)
        self._count = np.zeros(shape)

    @property
    def memory(self) -> tuple[Array, Array, Array]:
        """Angles [rad] and speeds [rad/s] that were read last, (B, N) each, and physics steps since then, (B, N)."""
        return self._angle, self._speed, self._count

    @property
    def numbers(self) -> dict[str, Array]:
        """Physics steps between readings, their period [s] and step [rad], and who reads, (B, 1) each."""
        return {"every": self._every, "period": self._period, "step": self._step, "present": self.present}

    def begin(self, rows: IntArray | slice, angle: Array, speed: Array) -> None:
        """Read resolvers at motor angles [rad] of robots that move at `speed` [rad/s] up to now, (B', N) each."""
        step = self._step[rows]
        before = _round(angle - self._period[rows] * speed, step)
        self._angle[rows] = now = _round(angle, step)
        self._speed[rows] = (now - before) / self._period[rows]
        self._count[rows] = 0.0

    def count(self, rows: IntArray | slice) -> BoolArray | None:
        """Go one physics step on; returns the mask of robots whose time to read has come, (B', N), None for none."""
        self._count[rows], due = count_step(self._count[rows], self._every[rows])
        return due if due.any() else None

    def look(self, rows: IntArray | slice, due: BoolArray, angle: Array) -> None:
        """Read resolvers at motor angles [rad] of the robots that are `due`, (B', N) each."""
        before = self._angle[rows], self._speed[rows]
        self._angle[rows], self._speed[rows] = look_again(before, due, angle, self._step[rows], self._period[rows])

    def read(self, rows: IntArray | slice) -> tuple[Array, Array]:
        """Angles [rad] and speeds [rad/s] that were read last, (B', N) each."""
        return self._angle[rows], self._speed[rows]


def count_step(count: Array, every: Array) -> tuple[Array, BoolArray]:
    """Count a physics step, (..., N); returns steps since the last reading, and where it is time for the next."""
    count = count + 1
    due = count >= every
    return np.where(due, 0.0, count), due


def look_again(
    before: tuple[Array, Array], due: BoolArray, angle: Array, step: Array, period: Array
) -> tuple[Array, Array]:
    """Return angles [rad] and speeds [rad/s] as resolvers read them now where it is time, else those `before`."""
    now, (last, speed) = _round(angle, step), before
    return np.where(due, now, last), np.where(due, (now - last) / period, speed)


def sum_errors(effects: Sequence[ResolverEffect], motor_angle: Array, motor_speed: Array) -> ResolverError:
    """Sum all errors of the position sensors, one after the other as in `Machine.read_by_resolver`."""
    angle, speed = motor_angle, motor_speed
    for effect in effects:
        error = effect.error(angle, speed)
        angle, speed = angle + error.angle, speed + error.speed
    return ResolverError(angle=angle - motor_angle, speed=speed - motor_speed)


def read_beyond(
    read: tuple[Array, Array], angle: Array, speed: Array, error: ResolverError, present: BoolArray
) -> ResolverError:
    """Compute what servos know beyond true motor angles [rad] and speeds [rad/s], (..., N) each.

    Args:
        read: angles and speeds that resolvers have read last.
        angle: true ones.
        speed: true ones.
        error: of the sensors, for servos that read nothing.
        present: mask of robots whose servos read resolvers.
    """
    return ResolverError(
        angle=np.where(present, read[0] - angle, error.angle), speed=np.where(present, read[1] - speed, error.speed)
    )


def _round(angle: Array, step: Array) -> Array:
    rounded: Array = np.round(angle / step) * step
    return rounded
