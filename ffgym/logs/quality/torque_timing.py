"""Checks of the recorded torque that need no robot: its delay against the motion, and its sign."""

from collections.abc import Iterator

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft

from ffgym.core.types import Array
from ffgym.logs.quality.check import Check, NotJudgedError, Seen
from ffgym.logs.quality.log import Log
from ffgym.logs.quality.signals import LAG_SPAN
from ffgym.logs.quality.torque_parts import TorqueParts, orthonormal, torque_parts

_TELLS = 0.2
"""Change of the log of the unexplained energy of a joint's torque that tells one delay from another, in the median of
all joints: of those that mostly rest, chance finds 0.1, and what ails one joint may look like a delay of its torque."""

_FEW, _TELLS_ALONE = 3, 0.75
"""Joints below which there is no such median, and what tells a delay then: a periodic torque that nobody knows of makes
0.6 in a log of one joint that moves to some poses; a delay of 110 ms makes 0.9 in its slowest triangle, 5 in others.
So does noise of angles, which makes 0.5 in slow sweeps."""

_REFUSED = 2.0
"""Delay over its limit from which on a log is refused. With noisy angles none is: friction that turns round slowly
looks late in one log, and a fit of the wiring over all of them tells more."""

_LATE, _ROWS_LATE = 0.02, 0.75
"""Delay that a torque may have: [s], or in rows if those are longer."""


def _lag(log: Log) -> Iterator[Seen]:
    parts = torque_parts(log)
    dt = float(np.median(np.diff(parts.t)))
    reach = min(max(3, round(LAG_SPAN / dt)), len(parts.t) // 8)
    joints = np.flatnonzero(log.excited & parts.clear & (np.ptp(parts.torque, axis=0) > 0))
    if not joints.size:
        raise NotJudgedError("no torque changes, or positions are too noisy")
    cost = _leftover(parts, joints.tolist(), reach)
    needed = _TELLS if len(joints) >= _FEW and parts.blur == 1 else _TELLS_ALONE
    lag = _smallest(cost, _TELLS) * dt if cost.min() < -needed else 0.0
    limit = max(_LATE, _ROWS_LATE * log.dt)
    message = (
        f"motor.effort is {'later' if lag > 0 else 'earlier'} than the motion explains by {abs(lag):.3g} s, must be "
        f"within {limit:.2g} s. Shift it by that time; or look for columns of two clocks, or of two runs."
    )
    columns = tuple(f"motor.effort.{log.joints[j]}" for j in joints)
    value = abs(lag) / limit
    yield Seen(value=value if parts.blur == 1 else min(value, _REFUSED), message=message, columns=columns)


def _smallest(cost: Array, least: float) -> int:
    """The shift nearest to none, of those from -R to R, whose `cost` (2 R + 1,) is the best but for `least`."""
    reach = len(cost) // 2
    good = np.flatnonzero(cost < cost.min() + least) - reach
    return int(good[np.argmin(np.abs(good))])


def _leftover(parts: TorqueParts, joints: list[int], reach: int) -> Array:
    """Log of what nothing explains of torques that are moved by -reach to reach rows, against none, (2 reach + 1,)."""
    inner = slice(reach, len(parts.t) - reach)
    shared, size = orthonormal(parts.common[inner]), next_fast_len(len(parts.t), real=True)
    shared_waves = rfft(shared, size, axis=0)
    costs = np.zeros((len(joints), 2 * reach + 1))
    for cost, j in zip(costs, joints, strict=True):
        own = parts.friction(j)[inner]
        own = orthonormal(own - shared @ (shared.T @ own))
        torque = parts.torque[:, j] - parts.torque[:, j].mean()
        columns = np.concatenate([shared_waves, rfft(own, size, axis=0)], axis=1)
        along = irfft(rfft(torque, size)[:, None] * columns.conj(), size, axis=0)[: 2 * reach + 1]
        explained, energy = np.sum(along**2, axis=1), np.cumsum(np.append(0.0, torque**2))
        total = energy[len(own) :] - energy[: -len(own)]
        cost[:] = np.log(np.maximum(total - explained, 1e-12 * total.max()))
    least: Array = np.median(costs - costs[:, [reach]], axis=0)
    return least


def _sign(log: Log) -> Iterator[Seen]:
    parts = torque_parts(log)
    others = orthonormal(parts.common)
    # On the motor's side, friction opposes the motor, which turns the other way where the gear ratio is negative.
    behind = log.recording.header.torque_semantics == "link_side"
    ways, whose = (np.ones(len(log.joints)), "joint") if behind else (np.sign(parts.gear_ratio), "motor")
    for j in np.flatnonzero(log.excited).tolist():
        torque, friction = (x - others @ (others.T @ x) for x in (parts.torque[:, j], ways[j] * parts.sliding(j)))
        size = float(np.linalg.norm(torque) * np.linalg.norm(friction))
        correlation = float(torque @ friction) / size if size > 0 else 0.0
        name = f"motor.effort.{log.joints[j]}"
        message = (
            f"{name} correlates with the sign of the {whose} speed by {correlation:.2f}, must be positive: friction "
            "would drive the joint. Turn the sign of the torque, or of the position."
        )
        yield Seen(value=-correlation, message=message, columns=(name,), joint=log.joints[j])


TORQUE_TIMING = (
    Check(
        name="torque_lag",
        figure="Delay of the torque against the motion, over 20 ms, or 0.75 rows where those are longer",
        unit="1",
        flag=1.0,
        refuse=_REFUSED,
        why="a torque out of step with the motion reads as inertia and friction of the wrong size; 12 ms are found in "
        "clean logs; recorders put a column off by a row, and no servo is stable with 40 ms between torque and motion",
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
