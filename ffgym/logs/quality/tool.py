"""Checks of the tool tracker against the arm, and of the sampling rate against what moves."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy

from ffgym.core.types import Array, IntArray
from ffgym.logs.quality.check import Seen, check, late
from ffgym.logs.quality.log import CheckedLog, NotJudgedError
from ffgym.logs.quality.signals import TINY
from ffgym.robot import resonances

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

_SAMPLES = 10
"""Samples that a period needs to be seen with its shape; two are needed to be seen at all."""

_LARGEST_SWING = 5.0
"""Largest factor that elastic joints may make of a path: a tenth of critical damping leaves 5, a unit makes 10."""


@dataclass(frozen=True, eq=False)
class ToolFit:
    """The measured tool path as a scaled, turned and shifted copy of the path that the joints make."""

    scale: float
    angle: float
    """Angle of the turn [deg]; nan if the path is too straight to tell."""
    offset: float
    """Between the middles of both paths [m]."""
    left: float
    """Share of the measured path that the copy leaves."""
    lag: float
    """Delay of the tracker [s]."""
    varies: bool
    """True if the speed along the path changes enough to tell that."""


@lru_cache(maxsize=4)
def _fit(log: CheckedLog) -> ToolFit:
    measured, planned, rows = _paths(log)
    if np.ptp(planned, axis=0).max() < _TRAVEL:
        raise NotJudgedError("the tool does not move")
    dt = float(np.median(np.diff(log.t[rows])))
    # rows by which the measured path is later: the peak of the correlation of the speeds along both, in any frame
    speed = _speed(planned, dt)
    fast, usual = (x - x.mean() for x in (_speed(measured, dt), speed))
    reach, middle = min(round(_LAG_SPAN / dt), len(fast) // 4), len(usual) - 1
    curve = scipy.signal.correlate(fast, usual, method="fft")
    lag = int(np.argmax(curve[middle - reach : middle + reach + 1])) - reach
    # the copy, of rows at once and of those that belong together if the measured path is later
    later, earlier = (slice(max(x, 0), len(rows) + min(x, 0)) for x in (lag, -lag))
    at_once, moved = _register(measured, planned), _register(measured[later], planned[earlier])
    scale, angle, left, straight = moved if moved[2] < 0.7 * at_once[2] else at_once
    return ToolFit(
        scale=scale,
        angle=np.nan if straight or left > 0.2 else angle,
        offset=float(np.linalg.norm(measured.mean(axis=0) - planned.mean(axis=0))),
        left=left,
        lag=lag * dt if moved[2] < at_once[2] else 0.0,
        varies=bool(speed.std() > _VARIES * speed.mean()),
    )


def _register(measured: Array, planned: Array) -> tuple[float, float, float, bool]:
    """Scale, angle [deg] and left share of the best copy of one path (R, 3) in another; whether it is straight.

    Reference:
        Umeyama (1991), IEEE TPAMI 13(4): least-squares estimation of transformation parameters.
    """
    a, b = measured - measured.mean(axis=0), planned - planned.mean(axis=0)
    u, s, vt = np.linalg.svd(a.T @ b)
    handed = np.array([1.0, 1.0, np.sign(np.linalg.det(u @ vt)) or 1.0])
    turn = (u * handed) @ vt
    scale = float(s @ handed / max(np.sum(b**2), TINY))
    left = float(np.sqrt(np.sum((a - scale * b @ turn.T) ** 2) / max(np.sum(a**2), TINY)))
    angle = float(np.degrees(np.arccos(np.clip((np.trace(turn) - 1) / 2, -1, 1))))
    extents = np.linalg.svd(b, compute_uv=False)
    return scale, angle, left, bool(extents[1] < 0.2 * extents[0])


def _paths(log: CheckedLog) -> tuple[Array, Array, IntArray]:
    """Measured and planned tool positions [m], (R, 3) each, and their rows."""
    if not log.recording.has("tcp.position"):
        raise NotJudgedError("there is no tcp.position")
    seen = np.isfinite(log.recording.vector("tcp.position")).all(axis=1)
    rows = np.flatnonzero(seen)
    rows = rows[:: max(1, len(rows) // _ROWS)]
    if len(rows) < 50:
        raise NotJudgedError("the tracker has fewer than 50 samples")
    measured = log.recording.vector("tcp.position")[rows]
    if log.robot is not None and log.robot.tool is not None and log.has_positions and log.is_described:
        return measured, log.arm.tcp_position(log.q[rows]), rows
    if log.recording.has("tcp_reference.position"):
        return measured, log.recording.vector("tcp_reference.position")[rows], rows
    raise NotJudgedError("it needs the robot with a tool, or tcp_reference.position")


def _speed(path: Array, dt: float) -> Array:
    """Way along a path (R, 3) in each `_WINDOW`."""
    window = max(1, round(_WINDOW / dt))
    return np.asarray(np.linalg.norm(path[window:] - path[:-window], axis=1))


@check
def _tracker_scale(log: CheckedLog) -> Iterator[Seen]:
    fit, swing = _fit(log), 1.0
    if log.robot is not None and log.is_described and not log.robot.drive.is_rigid.all():
        # a mass on a spring follows 1 / (1 - (f / f_1)^2) times as far; springs may be half as stiff as described
        ratio = bandwidth(log)[0] / first_resonance(log)
        swing = 1 / max(1 - 2 * ratio**2, 1 / _LARGEST_SWING)
    unit, others = "It is in millimetres: divide by 1000", "Look at its unit, the gear ratios and the links"
    beyond = max(abs(np.log(max(fit.scale, 1e-12))) - np.log(swing), 0.0)
    words = {"fit": fit, "swing": swing, "hint": unit if fit.scale > 100 else others}
    yield Seen(float(beyond) if fit.left < 0.5 else 0.0, _COLUMNS, words=words)


@check
def _tracker_motion(log: CheckedLog) -> Iterator[Seen]:
    yield Seen(_fit(log).left, _COLUMNS)


@check
def _tracker_frame(log: CheckedLog) -> Iterator[Seen]:
    fit = _fit(log)
    if np.isnan(fit.angle):
        raise NotJudgedError("the tool moves too straight, or not as the joints do")
    yield Seen(fit.angle, _COLUMNS, words={"fit": fit})


@check
def _tracker_lag(log: CheckedLog) -> Iterator[Seen]:
    fit = _fit(log)
    if fit.left > 0.5:
        raise NotJudgedError("the tool does not move as the joints do")
    if not fit.varies:
        raise NotJudgedError("the speed along the path hardly changes")
    yield Seen(abs(fit.lag), _COLUMNS, words={"late": late(fit.lag)})


@check
def _tracker_clock(log: CheckedLog) -> Iterator[Seen]:
    if not log.recording.has("tcp.timestamp"):
        raise NotJudgedError("there is no tcp.timestamp")
    rows = np.flatnonzero(np.isfinite(log.recording["tcp.timestamp"]))
    if len(rows) < 50:
        raise NotJudgedError("the tracker has fewer than 50 samples")
    clock, t = log.recording["tcp.timestamp"][rows], log.t[rows]
    rate = float(np.polyfit(t - t[0], clock - clock[0], 1)[0])
    backwards = bool(np.any(np.diff(clock) < 0))
    words = {"rate": rate, "backwards": " and backwards" if backwards else ""}
    yield Seen(1.0 if backwards else abs(rate - 1), ("tcp.timestamp",), words=words)


def first_resonance(log: CheckedLog) -> float:
    """First resonance of the arm on its springs [Hz], in the middle of the log."""
    if log.robot is None or not log.has_positions or not log.is_described:
        raise NotJudgedError("it needs the robot and positions")
    if log.robot.drive.is_rigid.all():
        raise NotJudgedError("all joints of the robot are rigid")
    return float(resonances(log.arm, log.q[len(log.q) // 2])[0])


def bandwidth(log: CheckedLog) -> tuple[float, str]:
    """Frequency [Hz] below which 90 % of the power of the speed lie, and the joint where that is highest."""
    if not log.excited.any():
        raise NotJudgedError("no joint moves")
    if len(log.t) < 64:
        raise NotJudgedError("there are fewer than 64 rows")
    speed = log.dq[:, log.excited]
    frequency, power = scipy.signal.welch(
        speed / np.maximum(speed.std(axis=0), 1e-300), fs=1 / log.dt, nperseg=min(4096, len(speed)), axis=0
    )
    share = np.cumsum(power, axis=0) / np.maximum(power.sum(axis=0), 1e-300)
    held = frequency[np.argmax(share > 0.9, axis=0)]
    j = int(np.argmax(held))
    return float(held[j]), log.joints[int(np.flatnonzero(log.excited)[j])]


@check
def _rate_for_resonance(log: CheckedLog) -> Iterator[Seen]:
    first, rate = first_resonance(log), 1 / log.dt
    words = {"rate": rate, "samples": rate / first, "first": first}
    yield Seen(_SAMPLES * first / rate, ("timestamp",), words=words)


@check
def _rate_for_motion(log: CheckedLog) -> Iterator[Seen]:
    held, joint = bandwidth(log)
    yield Seen(_SAMPLES * held * log.dt, ("timestamp",), joint, {"held": held, "samples": 1 / (held * log.dt)})
