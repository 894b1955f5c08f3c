"""Distance of the tool from its path, at every step; columns are added one by one, whatever the number of rows."""

import numpy as np

from ffgym.envs.motion import Columns
from ffgym.types import Array


def path_error(tcp: Array, rows: Array, columns: Columns, centre: Array, normal: Array) -> Array:
    """Distance of the TCP from its path [m], shape (B,).

    On a circle it is the distance to its nearest point, in its plane, as `ffgym.metrics.path_errors`; elsewhere the
    part of TCP - reference across the direction of motion, all of it at rest.

    Args:
        tcp: without the offset at standstill [m], shape (B, 3).
        rows: rows of the motions now, shape (B, W).
        columns: what stands where in them.
        centre: of the circles [m], shape (B, 3).
        normal: of their plane, shape (B, 3).
    """
    away, along = tcp - rows[:, columns.tcp], rows[:, columns.tangent]
    across = away - _dot(away, along)[:, None] * along
    arm = tcp - centre
    flat = arm - _dot(arm, normal)[:, None] * normal
    radius = rows[:, columns.radius]
    return np.where(radius > 0, np.abs(np.sqrt(_dot(flat, flat)) - radius), np.sqrt(_dot(across, across)))


def _dot(a: Array, b: Array) -> Array:
    return a[:, 0] * b[:, 0] + a[:, 1] * b[:, 1] + a[:, 2] * b[:, 2]
