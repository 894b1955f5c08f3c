"""Distance of the tool from its path, at every step; rows are independent of each other, bit for bit."""

import numpy as np

from ffgym.core.types import Array
from ffgym.envs.motion import Columns


def path_error(tcp: Array, rows: Array, columns: Columns, centre: Array, normal: Array) -> Array:
    """Distance of the TCP from its path [m], shape (B,).

    On a circle it is the distance to its nearest point, in its plane, as `ffgym.recordings.metrics.path_errors`;
    elsewhere the part of TCP - reference across the direction of motion, all of it at rest. Where a motion tells how
    its path bends, what the path leaves its tangent by, s^2 / 2 times the curvature, is taken off at the TCP's distance
    s along it.

    Args:
        tcp: without the offset at standstill [m], shape (B, 3).
        rows: rows of the motions now, shape (B, W).
        columns: what stands where in them.
        centre: of the circles [m], shape (B, 3).
        normal: of their plane, shape (B, 3).
    """
    radius = rows[:, columns.radius]
    circle = (radius > 0)[:, None]
    arm = tcp - np.where(circle, centre, rows[:, columns.tcp])
    drop = np.where(circle, normal, rows[:, columns.tangent])
    along = _dot(arm, drop)[:, None]
    left = arm - along * drop - 0.5 * along**2 * rows[:, columns.bend]
    return np.abs(np.sqrt(_dot(left, left)) - radius)  # the radius is 0 elsewhere


def _dot(a: Array, b: Array) -> Array:
    product: Array = (a * b).sum(axis=1)
    return product
