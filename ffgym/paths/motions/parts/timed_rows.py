"""Rows of a table that have times, as a path in time: splines that are twice continuously differentiable."""

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from ffgym.core.types import Array
from ffgym.paths.motion import CartesianPath, JointPath, Segment, sample
from ffgym.paths.motions.table import Table

AT_REST = 0.05
"""Share of the largest speed up to which a table counts as starting or ending at rest; chosen: rows of a log that
begins as the robot does are farther apart than its first movement."""


def followed(table: Table, t: Array, label: str) -> Callable[[Array | None, float], JointPath | CartesianPath]:
    """What samples a table with times `t` at the control step.

    A table that ends at rest is held up to the next sample; one that ends at speed ends with the last sample before.
    """
    points = table.positions if table.joints is None else table.joints
    assert points is not None
    turned = None if table.rotations is None else _quaternions(table.rotations)
    curve, turn = _spline(t, points), None if turned is None else _spline(t, turned)
    held = all(_rests(t, rows)[1] for rows in (points, turned) if rows is not None)

    def evaluate(tau: Array) -> tuple[Array, Array, Array]:
        return _at(curve, tau, t[-1])

    def path(_: Array | None, dt: float) -> JointPath | CartesianPath:
        duration = float(t[-1] if held else dt * np.floor(t[-1] / dt + 1e-9))
        times, *series, phases = sample([Segment(label=label, kind="motion", duration=duration, evaluate=evaluate)], dt)
        if table.joints is not None:
            return JointPath(name=label, t=times, q=series[0], dq=series[1], ddq=series[2], phases=phases)
        return CartesianPath(
            name=label,
            t=times,
            position=series[0],
            velocity=series[1],
            acceleration=series[2],
            phases=phases,
            **({} if turn is None else _turning(*_at(turn, times, t[-1]))),
        )

    return path


def _rests(t: Array, rows: Array) -> tuple[bool, bool]:
    """Whether rows (T, D) start and end at rest."""
    speed = np.linalg.norm(np.diff(rows, axis=0), axis=1) / np.diff(t)
    return bool(speed[0] <= AT_REST * speed.max()), bool(speed[-1] <= AT_REST * speed.max())


def _spline(t: Array, rows: Array) -> CubicSpline[Any]:
    """Cubic spline through rows (T, D), at rest at an end where they are."""
    starts, ends = _rests(t, rows)
    return CubicSpline(t, rows, bc_type=("clamped" if starts else "not-a-knot", "clamped" if ends else "not-a-knot"))


def _at(curve: CubicSpline[Any], t: Array, end: float) -> tuple[Array, Array, Array]:
    """Value and derivatives at times `t`; after the end it stays where it is."""
    inside, still = np.minimum(t, end), (t > end)[:, None]
    return curve(inside), np.where(still, 0.0, curve(inside, 1)), np.where(still, 0.0, curve(inside, 2))


def _quaternions(rotations: Array) -> Array:
    """Unit quaternions of rotations (T, 3, 3), scalar first, each on the side of the one before, shape (T, 4)."""
    values = Rotation.from_matrix(rotations).as_quat(scalar_first=True)
    flips = np.where((values[1:] * values[:-1]).sum(axis=1) < 0, -1.0, 1.0)
    return values * np.cumprod(np.append(1.0, flips))[:, None]


def _turning(q: Array, dq: Array, ddq: Array) -> dict[str, Array]:
    r"""Orientation and its rates in world axes, of quaternions of any length and their derivatives, (T, 4) each.

    .. math:: \omega = 2 \operatorname{Im}(\dot q \bar q) / |q|^2
    """
    square = (q * q).sum(axis=1)[:, None]
    velocity = 2 * _imaginary(dq, q) / square
    growth = 2 * (q * dq).sum(axis=1)[:, None] / square
    return {
        "rotation": Rotation.from_quat(q, scalar_first=True).as_matrix(),
        "angular_velocity": velocity,
        "angular_acceleration": 2 * _imaginary(ddq, q) / square - growth * velocity,
    }


def _imaginary(a: Array, b: Array) -> Array:
    """Vector of a times the conjugate of b, quaternions (T, 4), shape (T, 3)."""
    product: Array = b[:, :1] * a[:, 1:] - a[:, :1] * b[:, 1:] - np.cross(a[:, 1:], b[:, 1:])
    return product
