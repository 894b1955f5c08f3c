"""What the torque of a joint may be made of if nothing but its motion is known: positions, accelerations, friction."""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import final

import numpy as np

from ffgym.core.types import Array, BoolArray
from ffgym.logs.quality.check import NotJudgedError
from ffgym.logs.quality.log import RESTING, SMOOTHING, Log, averaged

_PERIOD = 0.004
"""Time [s] over which rows are averaged first; delays are judged from some of them on."""

_TRAVELS = (1e-3, 4e-3, 1.6e-2, 6.4e-2)
"""Angles of the motor [rad] over which friction may turn round, as e^-1; 3e-3 to 2e-2 in robots, 8e-3 in an axis
without a gearbox."""

_SLOW = (1 / 100, 1 / 30, 1 / 10, 1 / 3)
"""Shares of a joint's largest speed within which friction may be more, or less, than above."""

_RESTS, _MOVES = 3.0, 10.0
"""Noise of the speed below which a joint rests, whose bristles noise would shake loose; and its largest speed from
which on a joint can be told from one that rests, both in standard deviations."""

_TINY = 1e-10
"""Share of the largest energy in one direction of several columns below which it is rounding."""


@final
@dataclass(frozen=True, eq=False)
class TorqueParts:
    """Motion and torque at R rows, averaged over `_PERIOD`; N joints."""

    t: Array
    """[s], shape (R,)."""
    q: Array
    """[rad or m, link side], shape (R, N)."""
    dq: Array
    ddq: Array
    torque: Array
    """As recorded, shape (R, N)."""
    gear_ratio: Array
    """Shape (N,)."""
    trembling: Array
    """Noise of the speeds [rad/s or m/s, link side], shape (N,)."""

    blur: int
    """Rows over which the torque was averaged twice, 1 where it was not."""

    def as_torque(self, values: Array) -> Array:
        """Columns (R, ...), averaged as the torque is."""
        return values if self.blur == 1 else averaged(averaged(values, self.blur), self.blur)

    @property
    def clear(self) -> BoolArray:
        """Joints whose motion stands out of the noise of their positions, shape (N,)."""
        return np.asarray(np.abs(self.dq).max(axis=0) > _MOVES * self.trembling)

    @cached_property
    def common(self) -> Array:
        """Constants, positions and accelerations of all joints, of which gravity and inertia are made, (R, K)."""
        return np.column_stack([np.ones(len(self.q)), self.q, np.sin(self.q), np.cos(self.q), self.ddq])

    def speed(self, j: int) -> Array:
        """Speed of joint `j` over its largest, (R,)."""
        return np.asarray(self.dq[:, j] / max(np.abs(self.dq[:, j]).max(), np.finfo(np.float64).tiny))

    def sliding(self, j: int) -> Array:
        """Friction of joint `j` where it slides: the sign of its speed, smoothly, (R,)."""
        return self.as_torque(np.tanh(self.speed(j) / RESTING))

    def friction(self, j: int) -> Array:
        """Parts of the friction of joint `j`: its speed, and bristles of any length, stronger when slow (R, F)."""
        speed, bristles = self.speed(j)[:, None], self._bristles[:, j]
        slow = [bristles * np.exp(-np.abs(speed) / share) for share in _SLOW]
        return self.as_torque(np.column_stack([speed, bristles, *slow]))

    @cached_property
    def _bristles(self) -> Array:
        """Friction of size 1 that turns round over each of `_TRAVELS`, (R, N, L).

        Reference:
            Dahl (1968), A solid friction model, Aerospace Corporation TOR-0158(3107-18)-1.
        """
        turned = np.diff(self.q, axis=0, prepend=self.q[:1]) * np.abs(self.gear_ratio)
        turned = np.where(np.abs(self.dq) > _RESTS * self.trembling, turned, 0.0)[..., None]
        ways, keeps = np.sign(turned), np.exp(-np.abs(turned) / _TRAVELS)
        bent, now = np.empty(keeps.shape), np.zeros(keeps.shape[1:])
        for row, (way, keep) in enumerate(zip(ways, keeps, strict=True)):
            now = way + (now - way) * keep
            bent[row] = now
        return bent


@lru_cache(maxsize=4)
def torque_parts(log: Log) -> TorqueParts:
    """Motion and torque of a log.

    Raises:
        NotJudgedError: if they are not in it, or it is too short.
    """
    if log.smooth_q is None or log.dq is None or log.ddq is None or not log.recording.has("motor.effort"):
        raise NotJudgedError("motor.effort or all positions are missing")
    every = log.rows(_PERIOD)
    count = len(log.t) // every
    if count < 100 or not log.excited.any():
        raise NotJudgedError("the log is too short, or no joint moves")

    def means(values: Array) -> Array:
        return np.asarray(values[: count * every].reshape(count, every, -1).mean(axis=1))

    torque = log.recording.joint_array("motor.effort")
    blur = 1
    if log.smoothing > SMOOTHING:  # as the motion is, so that it is no sharper
        torque = averaged(averaged(torque, log.rows(log.smoothing)), log.rows(log.smoothing))
        blur = max(1, round(log.rows(log.smoothing) / every))
    ratio = np.asarray(log.recording.header.gear_ratio)
    # an average over w rows differs by those at its ends: two samples of noise over its width
    trembling = np.sqrt(2) * log.angle_noise / max(log.smoothing, log.dt)
    return TorqueParts(
        t=means(log.t)[:, 0],
        q=means(log.smooth_q),
        dq=means(log.dq),
        ddq=means(log.ddq),
        torque=means(torque),
        gear_ratio=ratio,
        trembling=trembling,
        blur=blur,
    )


def orthonormal(columns: Array) -> Array:
    """Orthonormal columns (R, K') that span those of `columns` (R, K), each taken at its own size."""
    scaled = columns / np.maximum(np.abs(columns).max(axis=0), np.finfo(np.float64).tiny)
    energy, directions = np.linalg.eigh(scaled.T @ scaled)
    kept = energy > _TINY * energy[-1]
    return np.asarray(scaled @ (directions[:, kept] / np.sqrt(energy[kept])))
