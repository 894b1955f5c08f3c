"""Arms with more joints than their task needs: what the joints that are to spare do.

Many motions of such an arm put the tool on its path. We take the one that keeps fixed combinations of the joints,
C q = C q_0, where the rows of C span the motions that leave the tool where it is at the first pose q_0. There the
motion is the smallest one that moves the tool, in the sense of sum (dq_i / max_speed_i)^2, which needs no common unit
of hinges and sliding joints. C does not change along a path, so that speed and acceleration are exact derivatives, and
a path that comes back to a tool pose comes back to the joint positions. (Integrated minimum-norm speeds do not: Klein
and Huang 1983, IEEE Trans. SMC 13(2). Constraints for the spare joints: Baillieul 1985, Proc. IEEE ICRA.)
"""

from dataclasses import dataclass

import numpy as np

from ffgym.robot.arm import RigidArm
from ffgym.types import Array, IntArray

MAX_CONDITION = 1e3
"""Jacobian condition number that counts as a singularity; the built-in robot has 8-10 in its work area."""
_SAMPLES = 64
"""Random poses that show what the arm can do; chosen: two generic ones would do."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Hold:
    """Combinations of joints that keep their values, one set for each of T samples."""

    rows: Array
    """C, shape (T, S, N); S = 0 where no joint is to spare."""
    anchor: Array
    """Joint positions q_0, shape (T, N)."""

    @classmethod
    def at_poses(cls, arm: RigidArm, q: Array, turning: bool) -> "Hold":
        """Spare motions at every row of `q` (T, N), for a tool whose orientation matters (`turning`) or does not."""
        n_free = arm.robot.n_joints - mobility(arm, turning)
        if n_free == 0:
            return cls(rows=np.empty((len(q), 0, q.shape[1])), anchor=q)
        weight = arm.robot.kinematics.max_speed
        motions = np.linalg.svd(task_jacobian(arm, q, turning) * weight)[2][:, -n_free:] / weight
        return cls(rows=motions / np.linalg.norm(motions, axis=2, keepdims=True), anchor=q)

    def repeated(self, count: int) -> "Hold":
        """The same combinations, held for one pose, for `count` samples."""
        return Hold(
            rows=np.broadcast_to(self.rows, (count, *self.rows.shape[1:])),
            anchor=np.broadcast_to(self.anchor, (count, self.anchor.shape[1])),
        )

    def at(self, rows: slice | IntArray) -> "Hold":
        """Some of the samples."""
        return Hold(rows=self.rows[rows], anchor=self.anchor[rows])

    def extend(self, vector: Array, jacobian: Array, q: Array | None = None) -> tuple[Array, Array]:
        """Append what is held to a twist (T, M) and its Jacobian (T, M, N); `q` (T, N) is led back, None is at rest."""
        if self.rows.shape[1] == 0:
            return vector, jacobian
        back = np.zeros(self.rows.shape[:2]) if q is None else np.sum(self.rows * (self.anchor - q)[:, None], axis=2)
        return np.concatenate([vector, back], axis=1), np.concatenate([jacobian, self.rows], axis=1)


def task_jacobian(arm: RigidArm, q: Array, turning: bool) -> Array:
    """Jacobian of what matters of the tool, shape (T, 6, N), or (T, 3, N) where its orientation is free."""
    return arm.jacobian(q)[:, : 6 if turning else 3]


def any_poses(arm: RigidArm) -> Array:
    """Joint positions spread over the ranges of the joints, always the same, shape (K, N)."""
    low, high = arm.robot.kinematics.range.T
    return np.random.default_rng(0).uniform(low, high, size=(_SAMPLES, arm.robot.n_joints))


def mobility(arm: RigidArm, turning: bool) -> int:
    """Number of independent motions of the tool that the arm can make away from singularities."""
    sizes = np.linalg.svd(task_jacobian(arm, any_poses(arm), turning), compute_uv=False)
    return int(np.max(np.sum(sizes > sizes[:, :1] / MAX_CONDITION, axis=1)))
