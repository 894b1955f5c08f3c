"""Checks of the tool tracker against the arm: unit, scale, frame, delay, clock, and whether it saw this motion."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import final

import numpy as np
from scipy.signal import correlate

from ffgym.core.types import Array, IntArray
from ffgym.logs.quality.check import Check, NotJudgedError, Seen
from ffgym.logs.quality.log import Log
from ffgym.logs.quality.sampling import bandwidth, first_resonance

_COLUMNS = ("tcp.position.x", "tcp.position.y", "tcp.position.z")
_ROWS = 3000
"""Samples of the tracker that are compared; more would only cost time."""

_TRAVEL = 1e-4
"""Travel [m] of the tool from which on it moves: five times the noise of a laser tracker."""

_WINDOW = 0.02
"""Time [s] over which the speed of the tool is taken: noise of the tracker averages out."""

_LAG_SPAN = 0.3
"""Largest delay [s] that is looked for."""

_VARIES = 0.05
"""Change of the speed along a path, as a share of its mean, from which on a delay can be seen in it; chosen: below,
noise and vibration are most of what changes."""

_LARGEST_SWING = 5.0
"""Largest factor that elastic joints may make of a path: a tenth of critical damping leaves 5, a unit makes 10."""


@final
@dataclass(frozen=True, eq=False)
class Fit:
    """The measured tool path as a scaled, turned and shifted copy of the path that the joints make."""

    scale: float
    angle: float
    """Of the turn [deg]; nan if the path is too straight to tell."""
    offset: float
    """Between the middles of both paths [m]."""
    left: float
    """Share of the measured path that the copy leaves."""
    lag: float
    """By how much it is later [s]."""
    varies: bool
    """Whether the speed along the path changes enough to tell that."""


@lru_cache(maxsize=4)
def _fit(log: Log) -> Fit:
    measured, planned, rows = _paths(log)
    if np.ptp(planned, axis=0).max() < _TRAVEL:
        raise NotJudgedError("the tool does not move")
    dt = float(np.median(np.diff(log.t[rows])))
    at_once, lag = _registered(measured, planned), _lag(measured, planned, dt)
    late = _registered(*_shifted(measured, planned, lag))
    scale, angle, left, straight = late if late[2] < 0.7 * at_once[2] else at_once
    return Fit(
        scale=scale,
        angle=np.nan if straight or left > 0.2 else angle,
        offset=float(np.linalg.norm(measured.mean(axis=0) - planned.mean(axis=0))),
        left=left,
        lag=lag * dt if late[2] < at_once[2] else 0.0,
        varies=_varies(planned, dt),
    )


def _registered(measured: Array, planned: Array) -> tuple[float, float, float, bool]:
    """Scale, angle [deg] and left share of the best copy of one path (R, 3) in another; whether it is straight.

    Reference:
        Umeyama (1991), IEEE TPAMI 13(4): least-squares estimation of transformation parameters.
    """
    a, b = measured - measured.mean(axis=0), planned - planned.mean(axis=0)
    u, s, vt = np.linalg.svd(a.T @ b)
    handed = np.array([1.0, 1.0, np.sign(np.linalg.det(u @ vt)) or 1.0])
    turn = (u * handed) @ vt
    tiny = np.finfo(np.float64).tiny
    scale = float(s @ handed / max(np.sum(b**2), tiny))
    left = float(np.sqrt(np.sum((a - scale * b @ turn.T) ** 2) / max(np.sum(a**2), tiny)))
    angle = float(np.degrees(np.arccos(np.clip((np.trace(turn) - 1) / 2, -1, 1))))
    extents = np.linalg.svd(b, compute_uv=False)
    return scale, angle, left, bool(extents[1] < 0.2 * extents[0])


def _shifted(a: Array, b: Array, lag: int) -> tuple[Array, Array]:
    """Rows of two series that belong together if `a` is later by `lag` rows."""
    if lag == 0:
        return a, b
    return (a[lag:], b[:-lag]) if lag > 0 else (a[:lag], b[-lag:])


def _paths(log: Log) -> tuple[Array, Array, IntArray]:
    """Measured and planned tool positions [m], (R, 3) each, and their rows."""
    if not log.recording.has("tcp.position"):
        raise NotJudgedError("there is no tcp.position")
    seen = np.isfinite(log.recording.vector("tcp.position")).all(axis=1)
    rows = np.flatnonzero(seen)
    rows = rows[:: max(1, len(rows) // _ROWS)]
    if len(rows) < 50:
        raise NotJudgedError("the tracker has fewer than 50 samples")
    measured = log.recording.vector("tcp.position")[rows]
    if log.robot is not None and log.robot.tool is not None and log.q is not None and _same_joints(log):
        return measured, log.arm.tcp_position(log.q[rows]), rows
    if log.recording.has("tcp_reference.position"):
        return measured, log.recording.vector("tcp_reference.position")[rows], rows
    raise NotJudgedError("it needs the robot with a tool, or tcp_reference.position")


def _same_joints(log: Log) -> bool:
    return log.robot is not None and log.robot.n_joints == len(log.joints)


def _lag(a: Array, b: Array, dt: float) -> int:
    """By how many rows path `a` (R, 3) is later than `b`: the peak of the correlation of their speeds, in any frame."""
    window = max(1, round(_WINDOW / dt))
    speeds = [np.linalg.norm(x[window:] - x[:-window], axis=1) for x in (a, b)]
    fast, planned = (speed - speed.mean() for speed in speeds)
    reach = min(round(_LAG_SPAN / dt), len(fast) // 4)
    curve = correlate(fast, planned, method="fft")
    middle = len(planned) - 1
    return int(np.argmax(curve[middle - reach : middle + reach + 1])) - reach


def _varies(path: Array, dt: float) -> bool:
    """Whether the speed along a path (R, 3) changes."""
    window = max(1, round(_WINDOW / dt))
    speed = np.linalg.norm(path[window:] - path[:-window], axis=1)
    return bool(speed.std() > _VARIES * speed.mean())


def _swing(log: Log) -> float:
    """Factor by which the springs of the arm may enlarge its path: 1 for slow motions, `_LARGEST_SWING` at resonance.

    A mass on a spring follows 1 / (1 - (f / f_1)^2) times as far; the springs may be half as stiff as described.
    """
    if log.robot is None or log.robot.drive.is_rigid.all() or not _same_joints(log):
        return 1.0
    ratio = bandwidth(log)[0] / first_resonance(log)
    return 1 / max(1 - 2 * ratio**2, 1 / _LARGEST_SWING)


def _scale(log: Log) -> Iterator[Seen]:
    fit, swing = _fit(log), _swing(log)
    hint = (
        "It is in millimetres: divide by 1000" if fit.scale > 100 else "Look at its unit, the gear ratios and the links"
    )
    message = (
        f"tcp.position: the measured path is {fit.scale:.4g} times that of the joints, must be within 5 % beyond the "
        f"factor of {swing:.3g} that elastic joints may make of this motion. {hint}."
    )
    beyond = max(abs(np.log(max(fit.scale, 1e-12))) - np.log(swing), 0.0)
    yield Seen(value=float(beyond) if fit.left < 0.5 else 0.0, message=message, columns=_COLUMNS)


def _motion(log: Log) -> Iterator[Seen]:
    fit = _fit(log)
    message = (
        f"tcp.position: {fit.left:.0%} of the measured path is not that of the joints, must be below 50 %. Look for "
        "the tracker's log of another run, for axes in another order, or for another reflector."
    )
    yield Seen(value=fit.left, message=message, columns=_COLUMNS)


def _frame(log: Log) -> Iterator[Seen]:
    fit = _fit(log)
    if np.isnan(fit.angle):
        raise NotJudgedError("the tool moves too straight, or not as the joints do")
    message = (
        f"tcp.position: the frame of the tracker is turned by {fit.angle:.3g} deg and {fit.offset:.3g} m away from "
        "that of the robot, must be turned by less than 5 deg. Transform the positions into the world of the robot."
    )
    yield Seen(value=fit.angle, message=message, columns=_COLUMNS)


def _delay(log: Log) -> Iterator[Seen]:
    fit = _fit(log)
    if fit.left > 0.5:
        raise NotJudgedError("the tool does not move as the joints do")
    if not fit.varies:
        raise NotJudgedError("the speed along the path hardly changes")
    message = (
        f"tcp.position is {'later' if fit.lag > 0 else 'earlier'} than the joints by {abs(fit.lag):.3g} s, must be by "
        "less than 20 ms. Shift it by that time, or synchronise the clocks."
    )
    yield Seen(value=abs(fit.lag), message=message, columns=_COLUMNS)


def _clock(log: Log) -> Iterator[Seen]:
    if not log.recording.has("tcp.timestamp"):
        raise NotJudgedError("there is no tcp.timestamp")
    rows = np.flatnonzero(np.isfinite(log.recording["tcp.timestamp"]))
    if len(rows) < 50:
        raise NotJudgedError("the tracker has fewer than 50 samples")
    clock, t = log.recording["tcp.timestamp"][rows], log.t[rows]
    rate = float(np.polyfit(t - t[0], clock - clock[0], 1)[0])
    backwards = bool(np.any(np.diff(clock) < 0))
    message = (
        f"tcp.timestamp runs {rate:.6g} times as fast as timestamp{' and backwards' if backwards else ''}, must run "
        "forwards and within 0.1 % of it. Convert it to seconds, or synchronise the clocks."
    )
    yield Seen(value=1.0 if backwards else abs(rate - 1), message=message, columns=("tcp.timestamp",))


TOOL = (
    Check(
        name="tracker_scale",
        figure="Measured over computed tool path, as |ln|, beyond what elastic joints may make of it",
        unit="1",
        flag=float(np.log(1.05)),
        refuse=float(np.log(2.0)),
        why="lengths of links and gear ratios are known to some percent at least; a unit makes 1000; an arm on springs "
        "follows farther than its joints, by 1 / (1 - 2 (f / f_1)^2) at most, with its first resonance f_1",
        judge=_scale,
    ),
    Check(
        name="tracker_motion",
        figure="Share of the tool path that the joints do not make",
        unit="1",
        flag=0.5,
        refuse=0.8,
        why="elasticity and friction in circles of 1 mm leave 0.2; another motion leaves most",
        judge=_motion,
    ),
    Check(
        name="tracker_frame",
        figure="Turn between the frames of tracker and robot",
        unit="deg",
        flag=5.0,
        why="a frame that was measured fits within a degree; stick-slip in small circles turns them by less than 5",
        judge=_frame,
    ),
    Check(
        name="tracker_lag",
        figure="Delay of the tracker",
        unit="s",
        flag=0.02,
        why="servo, elasticity and filters make some milliseconds, two clocks any number",
        judge=_delay,
    ),
    Check(
        name="tracker_clock",
        figure="Rate of the tracker's clock against that of the log, minus 1",
        unit="1",
        flag=1e-3,
        refuse=0.1,
        why="a quartz keeps 1e-4; a unit makes 1000",
        judge=_clock,
    ),
)
"""Checks of the tool tracker."""
