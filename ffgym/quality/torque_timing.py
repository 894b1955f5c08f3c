"""Checks of the recorded torque that need no robot: its delay against the motion, and its sign."""

from collections.abc import Iterator

import numpy as np
from scipy.signal import correlate

from ffgym.quality.check import Check, NotJudgedError, Seen
from ffgym.quality.log import RESTING, Log
from ffgym.quality.runs import stretches
from ffgym.quality.signals import LAG_SPAN
from ffgym.types import Array

_PERIOD = 0.004
"""Time [s] over which rows are averaged first: delays of less cannot be told from friction that builds up."""

_PRESLIDING = 2e-4
"""Travel [rad or m, link side] over which friction turns round: 2e-5 to 2e-4 in robots."""


_TELLS = 0.2
"""Fall of the log of the unexplained energy of a joint's torque from which on a delay is one: of joints that mostly
rest, chance finds 0.1."""


def _columns(log: Log) -> tuple[Array, Array, Array, Array, Array]:
    """Clock, q, dq, ddq, torque, averaged over `_PERIOD`."""
    if log.smooth_q is None or log.dq is None or log.ddq is None or not log.recording.has("motor.effort"):
        raise NotJudgedError("motor.effort or all positions are missing")
    every = log.rows(_PERIOD)
    count = len(log.t) // every
    if count < 100 or not log.excited.any():
        raise NotJudgedError("the log is too short, or no joint moves")

    def means(values: Array) -> Array:
        return np.asarray(values[: count * every].reshape(count, every, -1).mean(axis=1))

    torque = log.recording.joint_array("motor.effort")
    return means(log.t)[:, 0], means(log.smooth_q), means(log.dq), means(log.ddq), means(torque)


def _features(q: Array, dq: Array, ddq: Array, j: int) -> Array:
    """What the torque of joint `j` may be made of: positions, accelerations, friction; orthonormal columns (R, K)."""
    speed = dq[:, j] / max(np.abs(dq[:, j]).max(), np.finfo(np.float64).tiny)
    friction = [speed, np.tanh(speed / RESTING), np.tanh(speed / RESTING / 5)]
    parts = np.column_stack([np.ones(len(q)), q, np.sin(q), np.cos(q), ddq, *friction])
    basis, _ = np.linalg.qr(parts / np.maximum(np.abs(parts).max(axis=0), np.finfo(np.float64).tiny))
    return basis


def _lag(log: Log) -> Iterator[Seen]:
    t, q, dq, ddq, u = _columns(log)
    dt = float(np.median(np.diff(t)))
    reach = min(max(3, round(LAG_SPAN / dt)), len(t) // 8)
    joints = np.flatnonzero(log.excited & (np.ptp(u, axis=0) > 0))
    if not joints.size:
        raise NotJudgedError("no torque changes")
    cost = np.sum([_leftover(q, dq, ddq, u[:, j], int(j), reach) for j in joints], axis=0)
    best = int(np.argmin(cost))
    if cost[reach] - cost[best] < _TELLS * len(joints):
        best = reach
    lag = float(best - reach)
    if 0 < best < 2 * reach:
        before, top, after = cost[best - 1 : best + 2]
        bend = before - 2 * top + after
        lag += 0.5 * float((before - after) / bend) if bend > 0 else 0.0
    limit = max(0.01 + float(np.median([_turning(log, int(j)) for j in joints])), 0.75 * log.dt)
    message = (
        f"motor.effort is {'later' if lag > 0 else 'earlier'} than the motion explains by {abs(lag) * dt:.3g} s, must "
        f"be within {limit:.2g} s, the time in which friction turns round in this motion. Shift it by that time."
    )
    columns = tuple(f"motor.effort.{log.joints[j]}" for j in joints)
    yield Seen(value=abs(lag) * dt / limit, message=message, columns=columns)


def _turning(log: Log, j: int) -> float:
    """Time [s] in which joint `j` goes `_PRESLIDING` when it sets off or turns back, median; 0 if it never does."""
    assert log.smooth_q is not None
    assert log.dq is not None
    q, dq = log.smooth_q[:, j], log.dq[:, j]
    times = []
    for sign in (1, -1):
        still = np.flatnonzero(sign * dq <= 0)
        for rows in stretches((sign * dq > 0) & log.moving[:, j]):
            before = int(np.searchsorted(still, rows.start))
            start = int(still[before - 1]) if before else 0
            away = np.abs(q[start : rows.stop] - q[start]) > _PRESLIDING
            if away.any():
                times.append(int(np.argmax(away)) * log.dt)
    return float(np.median(times)) if times else 0.0


def _leftover(q: Array, dq: Array, ddq: Array, u: Array, j: int, reach: int) -> Array:
    """Log of what the features leave of a torque that is moved by -reach to reach rows, shape (2 reach + 1,)."""
    inner = slice(reach, len(u) - reach)
    basis = _features(q[inner], dq[inner], ddq[inner], j)
    centred = u - u.mean()
    explained = sum(correlate(centred, part, mode="valid", method="fft") ** 2 for part in basis.T)
    sums = np.concatenate([[0.0], np.cumsum(centred**2)])
    total = sums[len(basis) :] - sums[: 2 * reach + 1]
    return np.asarray(np.log(np.maximum(total - explained, 1e-12 * total.max())))


def _sign(log: Log) -> Iterator[Seen]:
    _, q, dq, ddq, u = _columns(log)
    for j in np.flatnonzero(log.excited):
        speed = dq[:, j] / np.abs(dq[:, j]).max()
        friction = np.tanh(speed / RESTING)
        others = np.column_stack([np.ones(len(q)), q, np.sin(q), np.cos(q), ddq])
        correlation = _partial(u[:, j], friction, others)
        name = f"motor.effort.{log.joints[j]}"
        message = (
            f"{name} correlates with the sign of the speed by {correlation:.2f}, must be positive: friction would "
            "drive the joint. Turn the sign of the torque, or of the position."
        )
        yield Seen(value=-correlation, message=message, columns=(name,), joint=log.joints[j])


def _partial(a: Array, b: Array, others: Array) -> float:
    """Correlation of `a` and `b` (R,) after what `others` (R, K) explain of both."""
    basis, _ = np.linalg.qr(others)
    a, b = a - basis @ (basis.T @ a), b - basis @ (basis.T @ b)
    size = np.linalg.norm(a) * np.linalg.norm(b)
    return float(a @ b / size) if size > 0 else 0.0


TORQUE_TIMING = (
    Check(
        name="torque_lag",
        figure="Delay of the torque against the motion, over what friction hides",
        unit="1",
        flag=1.0,
        why="a torque out of step with the motion reads as inertia and friction of the wrong size; the limit is 10 ms "
        "and the time of the first 0.2 mrad after a reversal, over which friction turns round, or 0.75 rows",
        judge=_lag,
    ),
    Check(
        name="torque_sign",
        figure="Correlation of the torque with the sign of the speed, negated",
        unit="1",
        flag=0.3,
        refuse=0.5,
        why="friction opposes motion in every machine, so that this is negative; noise makes 0.1",
        judge=_sign,
    ),
)
"""Checks of the torque that need no robot."""
