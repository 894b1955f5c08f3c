"""Checks of the recorded torque that need no robot: its delay against the motion, and its sign.

A torque may be made of whatever its motion allows: constants, positions, accelerations, and friction.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
import scipy

from ffgym.core.types import Array, BoolArray
from ffgym.logs.quality.check import ROWS, Seen, check, late
from ffgym.logs.quality.kinship import LAG_SPAN
from ffgym.logs.quality.log import RESTING, SMOOTHING, CheckedLog, NotJudgedError
from ffgym.logs.quality.signals import TINY, average

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

_TELLS = 0.2
"""Change of the log of the unexplained energy of a joint's torque that tells one delay from another, in the median of
all joints: of those that mostly rest, chance finds 0.1, and what ails one joint may look like a delay of its torque."""

_FEW, _TELLS_ALONE = 3, 0.75
"""Joints below which there is no such median, and what tells a delay then: a periodic torque that nobody knows of makes
0.6 in a log of one joint that moves to some poses; a delay of 110 ms makes 0.9 in its slowest triangle, 5 in others.
So does noise of angles, which makes 0.5 in slow sweeps."""

_LATE, _ROWS_LATE = 0.02, 0.75
"""Delay that a torque may have: [s], or in rows if those are longer."""


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
    """Recorded torque, shape (R, N)."""
    gear_ratio: Array
    """Shape (N,)."""
    trembling: Array
    """Noise of the speeds [rad/s or m/s, link side], shape (N,)."""

    blur: int
    """Rows over which the torque was averaged twice, 1 where it was not."""

    def as_torque(self, values: Array) -> Array:
        """Columns (R, ...), averaged as the torque is."""
        return values if self.blur == 1 else average(average(values, self.blur), self.blur)

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
        return np.asarray(self.dq[:, j] / max(np.abs(self.dq[:, j]).max(), TINY))

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
def torque_parts(log: CheckedLog) -> TorqueParts:
    """Motion and torque of a log."""
    if not log.has_positions or not log.recording.has("motor.effort"):
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
        torque = average(average(torque, log.rows(log.smoothing)), log.rows(log.smoothing))
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
    scaled = columns / np.maximum(np.abs(columns).max(axis=0), TINY)
    energy, directions = np.linalg.eigh(scaled.T @ scaled)
    kept = energy > _TINY * energy[-1]
    return np.asarray(scaled @ (directions[:, kept] / np.sqrt(energy[kept])))


@check
def _torque_lag(log: CheckedLog) -> Iterator[Seen]:
    parts = torque_parts(log)
    dt = float(np.median(np.diff(parts.t)))
    reach = min(max(3, round(LAG_SPAN / dt)), len(parts.t) // 8)
    joints = np.flatnonzero(log.excited & parts.clear & (np.ptp(parts.torque, axis=0) > 0))
    if not joints.size:
        raise NotJudgedError("no torque changes, or positions are too noisy")
    cost = _leftover(parts, joints.tolist(), reach)
    needed = _TELLS if len(joints) >= _FEW and parts.blur == 1 else _TELLS_ALONE
    good = np.flatnonzero(cost < cost.min() + _TELLS) - reach
    nearest = int(good[np.argmin(np.abs(good))])  # to no delay, of those that are as good as the best
    lag = nearest * dt if cost.min() < -needed else 0.0
    within = max(_LATE, _ROWS_LATE * log.dt)
    columns = tuple(f"motor.effort.{log.joints[j]}" for j in joints)
    # with noisy angles none is refused: friction that turns round slowly looks late in one log, and a fit of the
    # wiring over all of them tells more
    value = abs(lag) / within if parts.blur == 1 else min(abs(lag) / within, ROWS["torque_lag"]["refuse"])
    yield Seen(value, columns, words={"late": late(lag), "seconds": abs(lag), "within": within})


def _leftover(parts: TorqueParts, joints: list[int], reach: int) -> Array:
    """Log of what nothing explains of torques that are moved by -reach to reach rows, against none, (2 reach + 1,)."""
    inner = slice(reach, len(parts.t) - reach)
    shared, size = orthonormal(parts.common[inner]), scipy.fft.next_fast_len(len(parts.t), real=True)
    shared_waves = scipy.fft.rfft(shared, size, axis=0)
    costs = np.zeros((len(joints), 2 * reach + 1))
    for cost, j in zip(costs, joints, strict=True):
        own = parts.friction(j)[inner]
        own = orthonormal(own - shared @ (shared.T @ own))
        torque = parts.torque[:, j] - parts.torque[:, j].mean()
        columns = np.concatenate([shared_waves, scipy.fft.rfft(own, size, axis=0)], axis=1)
        along = scipy.fft.irfft(scipy.fft.rfft(torque, size)[:, None] * columns.conj(), size, axis=0)[: 2 * reach + 1]
        explained, energy = np.sum(along**2, axis=1), np.cumsum(np.append(0.0, torque**2))
        total = energy[len(own) :] - energy[: -len(own)]
        cost[:] = np.log(np.maximum(total - explained, 1e-12 * total.max()))
    least: Array = np.median(costs - costs[:, [reach]], axis=0)
    return least


@check
def _torque_sign(log: CheckedLog) -> Iterator[Seen]:
    parts = torque_parts(log)
    others = orthonormal(parts.common)
    # on the motor's side, friction opposes the motor, which turns the other way where the gear ratio is negative
    behind = log.recording.header.torque_semantics == "link_side"
    ways, whose = (np.ones(len(log.joints)), "joint") if behind else (np.sign(parts.gear_ratio), "motor")
    for j in np.flatnonzero(log.excited).tolist():
        torque, friction = (x - others @ (others.T @ x) for x in (parts.torque[:, j], ways[j] * parts.sliding(j)))
        size = float(np.linalg.norm(torque) * np.linalg.norm(friction))
        correlation = float(torque @ friction) / size if size > 0 else 0.0
        words = {"whose": whose, "correlation": correlation}
        yield Seen(-correlation, (f"motor.effort.{log.joints[j]}",), log.joints[j], words)
