"""Motions that no protocol of the project has: sines, points by trapezoids, splines through points, slow triangles."""

from collections.abc import Callable
from typing import Any, Literal, get_args

import numpy as np
from scipy.interpolate import make_interp_spline

from ffgym.core.types import Array

Kind = Literal["sines", "points", "spline", "triangles"]
KINDS: tuple[Kind, ...] = get_args(Kind)
"""All kinds of motions."""

REST = 0.3
"""Time of rest at either end [s]; chosen: springs come to rest."""

_SMOOTH = 0.08
"""Length of the window that rounds corners of speed [s]; chosen: the jerk of an industrial controller."""


def motion(
    kind: Kind, home: Array, reach: Array, speed: Array, duration: float, dt: float, rng: np.random.Generator
) -> tuple[Array, Array, Array]:
    """Joint positions, speeds and accelerations every `dt`, shape (T, N) each; T is odd.

    Args:
        kind: see `KINDS`.
        home: where the motion begins and ends [rad], shape (N,).
        reach: largest distance from there [rad], shape (N,).
        speed: largest speed [rad/s], shape (N,).
        duration: with the rest at either end [s].
        dt: of the samples [s].
        rng: chance.
    """
    count = 2 * round(duration / dt / 2) + 1
    t: Array = np.arange(count, dtype=np.float64) * dt - REST
    length = duration - 2 * REST
    profile = _PROFILES[kind](t, length, reach, speed, rng)
    width = max(3, round(_SMOOTH / dt))
    window: Array = np.hanning(width + 2)[1:-1]
    padded = np.pad(profile, ((width, width), (0, 0)), mode="edge")
    position = np.stack([np.convolve(p, window / window.sum(), "same")[width:-width] for p in padded.T], axis=1)
    rate: Array = np.gradient(position, dt, axis=0)
    acceleration: Array = np.gradient(rate, dt, axis=0)
    return home + position, rate, acceleration


def _sines(t: Array, length: float, reach: Array, speed: Array, rng: np.random.Generator) -> Array:
    """Two sines a joint, which grow and fade."""
    found = np.zeros((len(t), len(reach)))
    for j in range(len(reach)):
        for share in (0.6, 0.4):
            amplitude = share * reach[j] * rng.uniform(0.5, 1.0)
            fastest = share * speed[j] / (2 * np.pi * amplitude)
            frequency = np.clip(rng.uniform(0.3, 1.0) * fastest, 1 / length, 3.0)
            found[:, j] += min(amplitude, share * speed[j] / (2 * np.pi * frequency)) * np.sin(
                2 * np.pi * frequency * t + rng.uniform(0, 2 * np.pi)
            )
    ramp = np.clip(np.minimum(t, length - t) / (0.2 * length), 0, 1)
    return found * (ramp**2 * (3 - 2 * ramp))[:, None]


def _points(t: Array, length: float, reach: Array, speed: Array, rng: np.random.Generator) -> Array:
    """Move from point to point, all joints arriving together, with constant speed between ramps."""
    count = int(rng.integers(3, 6))
    points = np.vstack([np.zeros(len(reach)), rng.uniform(-1, 1, (count, len(reach))) * reach, np.zeros(len(reach))])
    each = length / (count + 1)
    points = _reachable(points, 0.7 * each * speed)  # a fifth of the time to speed up, and to rest
    knots, values = [], []
    for k, point in enumerate(points):
        knots += [k * each - 0.1 * each, k * each + 0.1 * each]
        values += [point, point]
    return np.stack([np.interp(t, knots, column) for column in np.array(values).T], axis=1)


def _spline(t: Array, length: float, reach: Array, speed: Array, rng: np.random.Generator) -> Array:
    """A spline of degree 5 through points by chance."""
    count = max(4, int(length / rng.uniform(0.4, 0.9)))
    points = rng.uniform(-1, 1, (count + 1, len(reach))) * reach
    points[0] = points[-1] = 0.0
    points = _reachable(points, 0.4 * length / count * speed)
    knots = np.linspace(0, length, count + 1)
    still = [(order, np.zeros(len(reach))) for order in (1, 2)]  # speed and acceleration at the ends
    ends: Any = (still, still)
    spline = make_interp_spline(knots, points, k=5, bc_type=ends)
    return np.asarray(spline(np.clip(t, 0, length)))


def _triangles(t: Array, length: float, reach: Array, speed: Array, rng: np.random.Generator) -> Array:
    """There and back at one slow speed after the other; joints turn at different times."""
    found = np.zeros((len(t), len(reach)))
    for j in range(len(reach)):
        slow = speed[j] * np.exp(rng.uniform(np.log(0.03), np.log(0.4), size=2))
        half, start, sign = length / 2, rng.uniform(0.0, 0.08) * length, rng.choice([-1.0, 1.0])
        for k, rate in enumerate(slow):
            way = min(rate * 0.42 * half, reach[j])
            begin = k * half + start
            knots = [begin, begin + 0.42 * half, begin + 0.84 * half]
            found[:, j] += sign * np.interp(t, knots, [0.0, way, 0.0])
    return found


def _reachable(points: Array, longest: Array) -> Array:
    """Points whose steps are no longer than `longest` (N,)."""
    steps = np.abs(np.diff(points, axis=0)).max(axis=0)
    return np.asarray(points * np.minimum(1.0, longest / np.maximum(steps, 1e-12)))


_PROFILES: dict[Kind, Callable[[Array, float, Array, Array, np.random.Generator], Array]] = {
    "sines": _sines,
    "points": _points,
    "spline": _spline,
    "triangles": _triangles,
}
