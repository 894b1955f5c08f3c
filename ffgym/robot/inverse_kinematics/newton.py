"""Newton's method for the joint positions of many poses at once."""

import numpy as np

from ffgym.core.types import Array, BoolArray
from ffgym.robot.dynamics.arm import RigidArm
from ffgym.robot.inverse_kinematics.goal import Goal
from ffgym.robot.inverse_kinematics.posture import Posture

TOLERANCE = 1e-10
"""Largest pose error left, [m] and [rad]: a thousandth of the resolver step at the TCP."""
ROUNDING = 1e-5
"""Largest pose error [m] and [rad] left in directions in which the arm cannot move its tool at all; what a right angle
that is written as 1.5708 rad makes of a plane 2 m wide lies within it."""
LARGEST_STEP = 0.3
"""Longest Newton step of a joint [rad or m], so that an iteration cannot jump to another branch."""
_MAX_ITERATIONS = 40
_DAMPING = 1e-9
"""Keeps the normal equations solvable at an exact singularity; too small to slow Newton down."""


def newton(arm: RigidArm, goal: Goal, posture: Posture, q: Array) -> tuple[Array, BoolArray]:
    """Newton's iteration on every row at once; of an arm that cannot make all motions, Gauss's and Newton's.

    Args:
        arm: the robot.
        goal: T tool poses.
        posture: where the joints to spare would be.
        q: joint positions to start from, shape (T, N).

    Returns:
        Joint positions (T, N), the nearest ones found, and whether they meet the goal (T,).
    """
    q = q.copy()
    met = np.zeros(len(q), dtype=np.bool_)
    active = np.arange(len(q))
    for _ in range(_MAX_ITERATIONS):
        twist, jacobian = goal.at(active).miss(arm, q[active])
        matrix, away = posture.demands(jacobian, q[active])
        miss = np.concatenate([twist, -away], axis=1)
        step = solve_twist(matrix, miss)
        left = step if matrix.shape[1] > matrix.shape[2] else miss  # what is missed for good takes no step
        settled = np.abs(left).max(axis=1) <= TOLERANCE
        met[active] = settled & (np.abs(twist).max(axis=1) <= ROUNDING)
        active, step = active[~settled], step[~settled]
        if active.size == 0:
            break
        length = np.abs(step).max(axis=1, keepdims=True)
        q[active] += step * np.minimum(1.0, LARGEST_STEP / np.maximum(length, 1e-300))
    return q, met


def solve_twist(matrix: Array, twist: Array) -> Array:
    """Joint steps or speeds x (T, N) with `matrix` (T, M, N) x = `twist` (T, M), by damped normal equations.

    Where there are several (M < N) it is the smallest one, where there is none (M > N) the one that comes nearest.
    """
    transposed = matrix.swapaxes(1, 2)
    n_rows, n_joints = matrix.shape[1:]
    if n_rows > n_joints:
        gram = transposed @ matrix + _DAMPING**2 * np.eye(n_joints)
        return _solved(gram, transposed @ twist[:, :, None])[:, :, 0]
    gram = matrix @ transposed + _DAMPING**2 * np.eye(n_rows)
    return (transposed @ _solved(gram, twist[:, :, None]))[:, :, 0]


def _solved(gram: Array, right: Array) -> Array:
    """Solutions x (T, M, 1) of gram x = right; the smallest ones where a matrix is exactly singular."""
    try:
        return np.asarray(np.linalg.solve(gram, right), dtype=np.float64)
    except np.linalg.LinAlgError:  # raised if any row is; the others keep their bits
        if len(gram) == 1:
            return np.linalg.pinv(gram, hermitian=True) @ right
        return np.concatenate([_solved(gram[i : i + 1], right[i : i + 1]) for i in range(len(gram))])
