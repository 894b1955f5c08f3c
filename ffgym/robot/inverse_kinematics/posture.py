r"""Arms with more joints than their task needs: of all joint positions that put the tool there, which are taken.

The nearest ones to a given posture :math:`q_0`, in the measure :math:`\sum ((q_i - q_{0,i}) / \dot q_{max,i})^2`, which
needs no common unit of hinges and sliding joints. With :math:`D` for its weights and :math:`Z` for the motions that
leave the tool where it is, they obey

.. math:: Z(q)^T D (q - q_0) = 0, \quad \text{or} \quad D (q - q_0) = J(q)^T \lambda

so that joint positions are a function of the tool pose: a path that comes back to a pose comes back to the joint
positions, which integrated minimum-norm speeds do not. Speed and acceleration are its exact derivatives.

Reference:
    Baillieul (1985), Kinematic programming alternatives for redundant manipulators, IEEE ICRA; on motions that do not
    come back: Klein and Huang (1983), IEEE Trans. SMC 13(2).
"""

from dataclasses import dataclass

import numpy as np

from ffgym.core.types import Array
from ffgym.robot.dynamics.arm import RigidArm
from ffgym.robot.inverse_kinematics.jacobian_rates import jacobian_rates, jacobian_slope
from ffgym.robot.inverse_kinematics.mobility import mobility


@dataclass(frozen=True, kw_only=True, eq=False)
class Posture:
    """Where the joints to spare of an arm would be, for tool poses with or without orientation."""

    anchor: Array
    """Joint positions q_0, shape (N,)."""
    weight: Array
    """Diagonal of D, shape (N,)."""
    n_rows: int
    """Rows of the Jacobian that matter M: 6, or 3 where the orientation of the tool is free."""
    n_spare: int
    """Number of joints to spare S."""

    @classmethod
    def near(cls, arm: RigidArm, anchor: Array, *, turning: bool) -> "Posture":
        """Posture near `anchor` for a tool whose orientation matters (`turning`) or does not."""
        speed = arm.robot.kinematics.max_speed
        n_spare = arm.robot.n_joints - mobility(arm, turning=turning)
        n_rows = 6 if turning else 3
        return cls(anchor=anchor, weight=(speed.mean() / speed) ** 2, n_rows=n_rows, n_spare=n_spare)

    def demands(self, jacobian: Array, q: Array) -> tuple[Array, Array]:
        """What is asked of the joints at `q` (T, N) beside the pose of the tool.

        Returns:
            Derivative by q of all that is asked, the rows of the Jacobian (T, 6, N) that matter and those of the joints
            to spare, shape (T, M + S, N); and how far the latter are from their posture, shape (T, S).
        """
        task = jacobian[:, : self.n_rows]
        if self.n_spare == 0:
            return task, np.empty((len(q), 0))
        free, along = self._split(task)
        pull = self.weight * (q - self.anchor)
        slope = jacobian_slope(jacobian, _times(along, pull))
        return np.concatenate([task, free @ (np.diag(self.weight) - slope)], axis=1), _times(free, pull)

    def bend(self, jacobian: Array, q: Array, dq: Array) -> Array:
        """What the rows of the joints to spare times acceleration must be, at speeds `dq` (T, N), shape (T, S)."""
        if self.n_spare == 0:
            return np.empty((len(q), 0))
        free, along = self._split(jacobian[:, : self.n_rows])
        force = _times(along, self.weight * (q - self.anchor))
        force_rate = _times(along, self.weight * dq - _times(jacobian_slope(jacobian, force), dq))
        rate, second = jacobian_rates(jacobian, dq)
        return _times(free, _times(second.swapaxes(1, 2), force) + 2 * _times(rate.swapaxes(1, 2), force_rate))

    def _split(self, task: Array) -> tuple[Array, Array]:
        """Motions Z^T (T, S, N) that leave the tool alone, and the inverse (T, 6, N) of J^T on the others."""
        rank = task.shape[2] - self.n_spare
        left, sizes, right = np.linalg.svd(task)
        sizes, singular = sizes[:, :rank], sizes[:, :rank] <= sizes[:, :1] * np.finfo(np.float64).eps
        inverse = np.where(singular, 0.0, 1 / np.where(singular, 1.0, sizes))
        along = np.zeros((len(task), 6, task.shape[2]))
        along[:, : self.n_rows] = (left[:, :, :rank] * inverse[:, None]) @ right[:, :rank]
        return right[:, rank:], along


def _times(matrix: Array, vector: Array) -> Array:
    """Products (T, A) of matrices (T, A, B) and vectors (T, B)."""
    return (matrix @ vector[:, :, None])[:, :, 0]
