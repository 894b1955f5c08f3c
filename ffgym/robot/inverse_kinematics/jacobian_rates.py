"""Derivatives of the geometric Jacobian (T, 6, N) of a serial arm, from the Jacobian itself.

Column j holds how joint j moves the TCP, v_j, and how it turns the tool, a_j, which is 0 for a sliding joint. A hinge
turns all that lies behind it, so that with i the first and l the last of two joints j and k

    dv_j/dq_k = a_i x v_l,    da_j/dq_k = a_k x a_j if k < j, else 0.
"""

import numpy as np

from ffgym.core.types import Array


def jacobian_slope(jacobian: Array, force: Array) -> Array:
    """Derivative of J(q)^T `force` by q at a constant force and moment on the tool (T, 6), shape (T, N, N)."""
    moving, turning = _columns(jacobian)
    push = np.cross(force[:, None, :3], turning) @ moving.swapaxes(1, 2)  # of v_j by q_k at [k, j], for k <= j
    twist = np.cross(force[:, None, 3:], turning) @ turning.swapaxes(1, 2)  # of a_j, likewise
    return np.tril((push + twist).swapaxes(1, 2)) + np.triu(push, 1)


def jacobian_rates(jacobian: Array, dq: Array) -> tuple[Array, Array]:
    """First and second time derivative of J, shape (T, 6, N) each, at joint speeds `dq` (T, N) that stay the same."""
    moving, turning = _columns(jacobian)
    speed = dq[:, :, None]
    spin, push = np.cumsum(turning * speed, axis=1), _behind(moving * speed)
    moving_rate = np.cross(spin, moving) + np.cross(turning, push)
    turning_rate = np.cross(spin, turning)
    spin_rate, push_rate = np.cumsum(turning_rate * speed, axis=1), _behind(moving_rate * speed)
    moving_second = (
        np.cross(spin_rate, moving)
        + np.cross(spin, moving_rate)
        + np.cross(turning_rate, push)
        + np.cross(turning, push_rate)
    )
    turning_second = np.cross(spin_rate, turning) + np.cross(spin, turning_rate)
    return _jacobian(moving_rate, turning_rate), _jacobian(moving_second, turning_second)


def _columns(jacobian: Array) -> tuple[Array, Array]:
    """How each joint moves the TCP and turns the tool, (T, N, 3) each."""
    columns = jacobian.swapaxes(1, 2)
    return columns[:, :, :3], columns[:, :, 3:]


def _jacobian(moving: Array, turning: Array) -> Array:
    return np.concatenate([moving, turning], axis=2).swapaxes(1, 2)


def _behind(parts: Array) -> Array:
    """Sum of what the joints behind each joint contribute, of parts (T, N, 3)."""
    return np.cumsum(parts[:, ::-1], axis=1)[:, ::-1] - parts
