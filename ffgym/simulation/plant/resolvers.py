"""Resolvers that servos read: angles in steps, at the drive's rate, and speeds as their differences (thesis 2.2.1)."""

from collections.abc import Sequence

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array, BoolArray, IntArray
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
        self._count = np.zeros((len(robots), 1))

    @property
    def memory(self) -> tuple[Array, Array, Array]:
        """Angles [rad] and speeds [rad/s] that were read last, (B, N) each, and physics steps since then, (B, 1)."""
        return self._angle, self._speed, self._count

    def begin(self, rows: IntArray | slice, angle: Array, speed: Array) -> None:
        """Read resolvers at motor angles [rad] of robots that move at `speed` [rad/s] up to now, (B', N) each."""
        step = self._step[rows]
        before = _round(angle - self._period[rows] * speed, step)
        self._angle[rows] = now = _round(angle, step)
        self._speed[rows] = (now - before) / self._period[rows]
        self._count[rows] = 0.0

    def count(self, rows: IntArray | slice) -> BoolArray | None:
        """Go one physics step on; returns the mask of robots whose time to read has come, (B', 1), None for none."""
        count = self._count[rows] + 1
        due = count >= self._every[rows]
        if not due.any():
            self._count[rows] = count
            return None
        self._count[rows] = np.where(due, 0.0, count)
        return due

    def look(self, rows: IntArray | slice, due: BoolArray, angle: Array) -> None:
        """Read resolvers at motor angles [rad] (B', N) of the robots that are `due`, (B', 1)."""
        now, before = _round(angle, self._step[rows]), self._angle[rows]
        self._speed[rows] = np.where(due, (now - before) / self._period[rows], self._speed[rows])
        self._angle[rows] = np.where(due, now, before)

    def read(self, rows: IntArray | slice) -> tuple[Array, Array]:
        """Angles [rad] and speeds [rad/s] that were read last, (B', N) each."""
        return self._angle[rows], self._speed[rows]


def _round(angle: Array, step: Array) -> Array:
    rounded: Array = np.round(angle / step) * step
    return rounded
