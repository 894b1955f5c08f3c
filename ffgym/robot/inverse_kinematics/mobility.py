"""Which motions of the tool an arm can make at all."""

import numpy as np

from ffgym.core.types import Array
from ffgym.robot.dynamics.arm import RigidArm

MAX_CONDITION = 1e3
"""Jacobian condition number that counts as a singularity; the built-in robot has 8-10 in its work area."""
_SAMPLES = 64
"""Random poses that show what the arm can do; chosen: two generic ones would do."""


def any_poses(arm: RigidArm, count: int = _SAMPLES) -> Array:
    """Joint positions spread over the ranges of the joints, always the same, shape (count, N)."""
    low, high = arm.robot.kinematics.range.T
    return np.random.default_rng(0).uniform(low, high, size=(count, arm.robot.n_joints))


def task_jacobian(arm: RigidArm, q: Array, *, turning: bool) -> Array:
    """Jacobian of what matters of the tool, shape (T, 6, N), or (T, 3, N) where its orientation is free."""
    return arm.jacobian(q)[:, : 6 if turning else 3]


def mobility(arm: RigidArm, *, turning: bool) -> int:
    """Number of independent motions of the tool that the arm can make away from singularities."""
    sizes = np.linalg.svd(task_jacobian(arm, any_poses(arm), turning=turning), compute_uv=False)
    return int(np.max(np.sum(sizes > sizes[:, :1] / MAX_CONDITION, axis=1)))
