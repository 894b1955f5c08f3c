"""Newton's method for the joint positions of many tool poses at once."""

from dataclasses import dataclass

import numpy as np

from ffgym.core.errors import FFGymError, check_rotation, check_rotations, check_shape
from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.robot.dynamics.arm import RigidArm


def rotation_error(wanted: Array, actual: Array) -> Array:
    """Rotation vectors [rad] in the world from `actual` (T, 3, 3) to `wanted` (3, 3) or (T, 3, 3), shape (T, 3).

    Exact to third order near zero.
    """
    turn = wanted @ actual.swapaxes(1, 2)
    axis = 0.5 * np.stack(
        [turn[:, 2, 1] - turn[:, 1, 2], turn[:, 0, 2] - turn[:, 2, 0], turn[:, 1, 0] - turn[:, 0, 1]], 1
    )
    sine, cosine = np.linalg.norm(axis, axis=1), 0.5 * (np.trace(turn, axis1=1, axis2=2) - 1.0)
    angle = np.arctan2(sine, cosine)
    vector = axis * np.where(sine > 1e-9, angle / np.where(sine > 1e-9, sine, 1.0), 1.0)[:, None]
    for i in np.flatnonzero((sine <= 1e-9) & (cosine < 0)):  # half a turn: its axis is what turn + 1 keeps
        kept = turn[i] + np.eye(3)
        longest = kept[:, np.argmax(np.linalg.norm(kept, axis=0))]
        vector[i] = np.pi * longest / np.linalg.norm(longest)
    return vector


@dataclass(frozen=True, kw_only=True, eq=False)
class Goal:
    """Poses of the tool at T samples, each on its own."""

    positions: Array
    """TCP in the world [m], shape (T, 3)."""
    rotations: Array | None
    """Orientation of tool0 in the world, shape (T, 3, 3); None leaves it free."""

    @classmethod
    def of(cls, positions: Array, rotation: Array | None) -> "Goal":
        """Check a goal; one `rotation` (3, 3) holds for all positions."""
        positions = check_shape("positions", positions, (None, 3))
        if len(positions) == 0:
            raise FFGymError("positions is empty, must hold at least one TCP position.")
        if rotation is None:
            return cls(positions=positions, rotations=None)
        if np.ndim(rotation) != 3:
            rotation = check_rotation("rotation", rotation)
            return cls(positions=positions, rotations=np.broadcast_to(rotation, (len(positions), 3, 3)))
        return cls(positions=positions, rotations=check_rotations("rotation", rotation, len(positions)))

    def __len__(self) -> int:
        return len(self.positions)

    def at(self, rows: slice | IntArray) -> "Goal":
        """Return some of the samples."""
        return Goal(positions=self.positions[rows], rotations=None if self.rotations is None else self.rotations[rows])

    def miss(self, arm: RigidArm, q: Array) -> tuple[Array, Array]:
        """Twist from the tool at `q` (T, N) to the goal, [m] and [rad], and the Jacobian there, shape (T, 6, N).

        The twist has shape (T, 6), or (T, 3) where the orientation is free.
        """
        position, rotation, jacobian = arm.pose_and_jacobian(q)
        away = self.positions - position
        if self.rotations is None:
            return away, jacobian
        return np.concatenate([away, rotation_error(self.rotations, rotation)], axis=1), jacobian


MAX_CONDITION = 1e3
"""Jacobian condition number that counts as a singularity; the built-in robot has 8-10 in its work area."""
_SAMPLES = 64
"""Random poses that show what the arm can do; chosen: two generic ones would do."""


def any_poses(arm: RigidArm, count: int = _SAMPLES) -> Array:
    """Draw joint positions spread over the ranges of the joints, always the same, shape (count, N)."""
    low, high = arm.robot.kinematics.range.T
    return np.random.default_rng(0).uniform(low, high, size=(count, arm.robot.n_joints))


def mobility(arm: RigidArm, *, turning: bool) -> int:
    """Count independent motions of the tool that the arm can make away from singularities."""
    sizes = np.linalg.svd(arm.jacobian(any_poses(arm))[:, : 6 if turning else 3], compute_uv=False)
    return int(np.max(np.sum(sizes > sizes[:, :1] / MAX_CONDITION, axis=1)))


def jacobian_slope(jacobian: Array, force: Array) -> Array:
    """Compute the derivative of J(q)^T `force` by q at constant force and moment on the tool (T, 6), (T, N, N)."""
    moving, turning = _columns(jacobian)
    push = np.cross(force[:, None, :3], turning) @ moving.swapaxes(1, 2)  # of v_j by q_k at [k, j], for k <= j
    twist = np.cross(force[:, None, 3:], turning) @ turning.swapaxes(1, 2)  # of a_j, likewise
    return np.tril((push + twist).swapaxes(1, 2)) + np.triu(push, 1)


def jacobian_rates(jacobian: Array, dq: Array) -> tuple[Array, Array]:
    """Compute first and second time derivatives of J, (T, 6, N) each, at constant joint speeds `dq` (T, N)."""
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
    """Return the velocity of the TCP and the turn of the tool per joint, (T, N, 3) each."""
    columns = jacobian.swapaxes(1, 2)
    return columns[:, :, :3], columns[:, :, 3:]


def _jacobian(moving: Array, turning: Array) -> Array:
    return np.concatenate([moving, turning], axis=2).swapaxes(1, 2)


def _behind(parts: Array) -> Array:
    """Sum contributions (T, N, 3) of the joints behind each joint."""
    return np.cumsum(parts[:, ::-1], axis=1)[:, ::-1] - parts


@dataclass(frozen=True, kw_only=True, eq=False)
class Posture:
    """Preferred posture of redundant joints, for tool poses with or without orientation."""

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
        """Build a posture near `anchor` for a tool whose orientation matters (`turning`) or does not."""
        speed = arm.robot.kinematics.max_speed
        n_spare = arm.robot.n_joints - mobility(arm, turning=turning)
        n_rows = 6 if turning else 3
        return cls(anchor=anchor, weight=(speed.mean() / speed) ** 2, n_rows=n_rows, n_spare=n_spare)

    def demands(self, jacobian: Array, q: Array) -> tuple[Array, Array]:
        """Evaluate the condition on redundant joints at `q` (T, N), beside the pose of the tool.

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
        """Compute the right-hand side of the redundant rows for accelerations, at speeds `dq` (T, N), shape (T, S)."""
        if self.n_spare == 0:
            return np.empty((len(q), 0))
        free, along = self._split(jacobian[:, : self.n_rows])
        force = _times(along, self.weight * (q - self.anchor))
        force_rate = _times(along, self.weight * dq - _times(jacobian_slope(jacobian, force), dq))
        rate, second = jacobian_rates(jacobian, dq)
        return _times(free, _times(second.swapaxes(1, 2), force) + 2 * _times(rate.swapaxes(1, 2), force_rate))

    def _split(self, task: Array) -> tuple[Array, Array]:
        """Return null motions Z^T (T, S, N) of the tool, and the inverse (T, 6, N) of J^T on the others."""
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

    Returns the nearest joint positions found from `q` on, shape (T, N), and whether they meet the goal, shape (T,).
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
        return _solve_normal_equations(gram, transposed @ twist[:, :, None])[:, :, 0]
    gram = matrix @ transposed + _DAMPING**2 * np.eye(n_rows)
    return (transposed @ _solve_normal_equations(gram, twist[:, :, None]))[:, :, 0]


def _solve_normal_equations(gram: Array, right: Array) -> Array:
    """Solve gram x = right for x (T, M, 1); the smallest solutions where a matrix is exactly singular."""
    try:
        return np.asarray(np.linalg.solve(gram, right), dtype=np.float64)
    except np.linalg.LinAlgError:  # raised if any row is; the others keep their bits
        if len(gram) == 1:
            return np.linalg.pinv(gram, hermitian=True) @ right
        return np.concatenate([_solve_normal_equations(gram[i : i + 1], right[i : i + 1]) for i in range(len(gram))])


def joint_rates(arm: RigidArm, q: Array, seed: Array, twist: Array, twist_rate: Array) -> tuple[Array, Array]:
    """Joint speeds and accelerations, shape (T, N) each, along joint positions that `solve_path` returned.

    Args:
        arm: the robot.
        q: joint positions of the path [rad or m], shape (T, N).
        seed: joint positions that `solve_path` was given, shape (N,).
        twist: speed of the TCP [m/s] and, unless the orientation is free, of tool0 [rad/s], shape (T, 6) or (T, 3).
        twist_rate: its time derivative, same shape.
    """
    n_rows = twist.shape[1]
    posture = Posture.near(arm, seed, turning=n_rows == 6)
    jacobian = arm.jacobian(q)
    slopes, away = posture.demands(jacobian, q)
    dq = solve_twist(slopes, np.hstack([twist, np.zeros_like(away)]))
    change = twist_rate - arm.bias_acceleration(q, dq)[:, :n_rows]
    return dq, solve_twist(slopes, np.hstack([change, posture.bend(jacobian, q, dq)]))
