"""Time laws of paths: the fastest jerk-limited motion within a speed limit on each stretch.

Speeds where stretches meet are the largest that a pass forwards and one backwards find reachable. Acceleration is zero
there, so that each stretch keeps its own limits to its very ends. What is left on a stretch is the classic profile of
seven phases between two speeds, in closed form but for one root. Libraries were weighed: ruckig solves the more general
problem of any state to any state and finds the same profiles, but has waypoints only as a service on the network, and
where the length of a stretch just allows its speeds it now and then runs backwards; toppra knows no limit of jerk. The
tests hold these profiles against ruckig's.
"""

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from ffgym.core.errors import check_number
from ffgym.core.types import Array

_SLACK = 1e-9
"""Share of a stretch kept free where a junction speed is just reached, so that rounding cannot make it short."""


@dataclass(frozen=True, kw_only=True)
class PathStretch:
    """A piece of a path with limits of its own. A length is in m, or in s for a path of joints; see `curves`."""

    length: float
    """> 0."""
    speed: float
    """Largest speed along the path, > 0."""
    acceleration: float
    """Largest acceleration along the path, > 0."""
    jerk: float
    """Largest jerk along the path, > 0."""

    def __post_init__(self) -> None:
        for name in ("length", "speed", "acceleration", "jerk"):
            check_number(f"{name} of a stretch", getattr(self, name), low=0.0, open_low=True)


@dataclass(frozen=True, kw_only=True, eq=False)
class TimeLaw:
    """Travelled length as a function of time: pieces of constant jerk, from rest to rest."""

    start: Array
    """Times at which the pieces start [s], increasing from 0, shape (K,)."""
    state: Array
    """Length, speed, acceleration and jerk at the start of each piece, shape (K, 4)."""
    duration: float
    """[s]."""
    length: float
    """Travelled in the end."""

    def at(self, t: Array) -> tuple[Array, Array, Array]:
        """Length, speed and acceleration at times `t` [s], shape (T,); at rest before the start and after the end."""
        inside = np.clip(t, 0.0, self.duration)
        piece = np.searchsorted(self.start, inside, side="right") - 1
        s, v, a, j = self.state[piece].T
        tau = inside - self.start[piece]
        ended = inside >= self.duration
        travelled = np.minimum(s + tau * (v + tau * (a / 2 + tau * j / 6)), self.length)
        return (
            np.where(ended, self.length, travelled),
            np.where(ended, 0.0, v + tau * (a + tau * j / 2)),
            np.where(ended, 0.0, a + tau * j),
        )

    def time_of(self, length: float) -> float:
        """Time [s] at which `length` has been travelled."""
        if length >= self.length:
            return self.duration
        piece = int(np.searchsorted(self.state[:, 0], length, side="right")) - 1
        first, last = (float(t) for t in np.append(self.start, self.duration)[piece : piece + 2])

        def short(t: float) -> float:
            return float(self.at(np.array([t]))[0][0]) - length

        return first if short(first) >= 0 else scipy.optimize.brentq(short, first, last, xtol=1e-13)


def time_law(stretches: Sequence[PathStretch]) -> TimeLaw:
    """Fastest time law from rest to rest, with zero acceleration where stretches meet."""
    speeds = junction_speeds(stretches)
    pieces, time, length = [], 0.0, 0.0
    for stretch, before, after in zip(stretches, speeds, speeds[1:], strict=False):
        duration, part = _profile(stretch, before, after)
        part[:, 0] += time
        part[:, 1] += length
        pieces.append(part)
        time, length = time + duration, length + stretch.length
    table = np.concatenate(pieces)
    return TimeLaw(start=table[:, 0], state=table[:, 1:], duration=time, length=length)


def junction_speeds(stretches: Sequence[PathStretch]) -> list[float]:
    """Largest speeds where stretches meet, with those at both ends of the path, which are 0."""
    caps = [min(a.speed, b.speed) for a, b in itertools.pairwise(stretches)]
    speeds = [0.0, *caps, 0.0]
    for i, stretch in enumerate(stretches):
        speeds[i + 1] = _reachable(stretch, speeds[i], speeds[i + 1])
    for i in reversed(range(len(stretches))):
        speeds[i] = _reachable(stretches[i], speeds[i + 1], speeds[i])
    return speeds


def _reachable(stretch: PathStretch, speed: float, wanted: float) -> float:
    """Largest speed up to `wanted` that the stretch can change to, or from, `speed`."""
    room = stretch.length * (1 - _SLACK)
    if wanted <= speed or _distance(stretch, speed, wanted - speed) <= room:
        return wanted
    return speed + _root(lambda change: _distance(stretch, speed, change) - room, wanted - speed)


def _distance(stretch: PathStretch, slow: float, change: float) -> float:
    """Least length over which speed rises from `slow` by `change`, or falls back; acceleration is zero at both ends."""
    time = sum(tau for tau, _ in _phases(stretch, change))
    return (slow + 0.5 * change) * time


def _root(excess: Callable[[float], float], high: float) -> float:
    """Find the zero of a rising function between 0, where it is negative, and `high`; small roots to all digits."""
    return float(scipy.optimize.brentq(excess, 0.0, high, xtol=np.finfo(np.float64).tiny, maxiter=1000))


def _profile(stretch: PathStretch, before: float, after: float) -> tuple[float, Array]:
    """Duration [s], and rows of start time, length, speed, acceleration and jerk, shape (K, 5), of one stretch."""
    slow, fast = sorted((before, after))
    extra = _extra_speed(stretch, slow, fast)
    peak, rise, fall = fast + extra, extra + (fast - before), extra + (fast - after)
    rising, falling = _phases(stretch, rise), [(tau, -jerk) for tau, jerk in _phases(stretch, fall)]
    first = _distance(stretch, before, rise)
    last = stretch.length - _distance(stretch, after, fall)
    cruise = [(max(last - first, 0.0) / peak, 0.0)]
    rows: list[tuple[float, ...]] = []
    time = 0.0
    for start, speed, phases in ((0.0, before, rising), (first, peak, cruise), (last, peak, falling)):
        state = (start, speed, 0.0)  # anew for each part, so that rounding does not reach the next
        for tau, jerk in phases:
            if tau > 0:
                rows.append((time, *state, jerk))
                s, v, a = state
                travelled = s + tau * (v + tau * (a / 2 + tau * jerk / 6))
                time, state = time + tau, (travelled, v + tau * (a + tau * jerk / 2), a + tau * jerk)
    return time, np.array(rows)


def _extra_speed(stretch: PathStretch, slow: float, fast: float) -> float:
    """Compute the extra speed of a stretch over the faster of its ends: up to its limit, or as its length allows."""

    def excess(extra: float) -> float:
        there, back = _distance(stretch, slow, extra + (fast - slow)), _distance(stretch, fast, extra)
        return there + back - stretch.length

    most = stretch.speed - fast
    if most <= 0 or excess(0.0) >= 0:
        return 0.0
    return most if excess(most) <= 0 else _root(excess, most)


def _phases(stretch: PathStretch, change: float) -> list[tuple[float, float]]:
    """Durations [s] and jerks of the three phases in which speed rises by `change` >= 0."""
    acceleration = min(stretch.acceleration, float(np.sqrt(change * stretch.jerk)))
    ramp = acceleration / stretch.jerk
    hold = change / acceleration - ramp if acceleration > 0 else 0.0
    return [(ramp, stretch.jerk), (hold, 0.0), (ramp, -stretch.jerk)]
