"""Joint angles for a TCP path with fixed tool orientation: Newton steps from sample to sample, on one branch."""

import numpy as np

from ffgym.errors import FFGymError, check_rotation, check_shape
from ffgym.robot.arm import RigidArm
from ffgym.types import Array

TOLERANCE = 1e-10
"""Largest pose error left, [m] and [rad]: a thousandth of the resolver step at the TCP."""
MAX_CONDITION = 1e3
"""Jacobian condition number that counts as a singularity; the built-in robot has 8-10 in its work area."""
_MAX_ITERATIONS = 40
_BLOCK = 256
_RESTARTS = 50
_LARGEST_STEP = 0.3
"""Longest Newton step of a joint [rad], so that an iteration cannot jump to another branch."""
_DAMPING = 1e-9
"""Keeps the normal equations solvable at an exact singularity; too small to slow Newton down."""


def solve_path(arm: RigidArm, positions: Array, rotation: Array, seed: Array) -> Array:
    """Joint angles [rad], shape (T, N), that put the TCP on `positions` with tool0 turned to `rotation`.

    Args:
        arm: the robot.
        positions: TCP positions in the world [m], shape (T, 3); neighbours must be close.
        rotation: orientation of tool0 in the world, shape (3, 3).
        seed: joint angles [rad], shape (N,), near the branch that is wanted.

    Raises:
        FFGymError: if a pose is unreachable, the path jumps to another branch, comes too near a singularity
            or leaves the joint limits.
    """
    positions = check_shape("positions", positions, (None, 3))
    if len(positions) == 0:
        raise FFGymError("positions is empty, must hold at least one TCP position.")
    rotation = check_rotation("rotation", rotation)
    seed = check_shape("seed", seed, (arm.robot.n_joints,))
    q = np.empty((len(positions), len(seed)))
    last = _first_pose(arm, positions[0], rotation, seed)
    for start in range(0, len(positions), _BLOCK):
        rows = slice(start, start + _BLOCK)
        q[rows] = _follow(arm, positions[rows], rotation, last, start)
        last = q[rows][-1]
    _check_joint_limits(arm, q)
    _check_singularity(arm, q)
    return q


def _follow(arm: RigidArm, positions: Array, rotation: Array, last: Array, start: int) -> Array:
    """Solve a block at once from the pose before it; halve the block until it stays on the branch."""
    q, error = _newton(arm, positions, rotation, np.tile(last, (len(positions), 1)))
    steps = np.abs(np.diff(np.vstack([last[None], q]), axis=0)).max(axis=1)
    if error.max() <= TOLERANCE and steps.max() <= _LARGEST_STEP:
        return q
    if len(positions) == 1:
        if error[0] > TOLERANCE:
            raise _unreachable(arm, positions[0], error[0], start)
        joint = int(np.argmax(np.abs(q[0] - last)))
        raise FFGymError(
            f"The path jumps at sample {start}: joint {arm.robot.joints[joint]} would move {steps[0]:.2f} rad in one "
            f"sample. Use a shorter sample time, or a path that stays on one branch."
        )
    half = len(positions) // 2
    first = _follow(arm, positions[:half], rotation, last, start)
    return np.vstack([first, _follow(arm, positions[half:], rotation, first[-1], start + half)])


def _first_pose(arm: RigidArm, position: Array, rotation: Array, seed: Array) -> Array:
    """Pose nearest to the seed, found from the seed and from random poses around it within the joint limits."""
    limits = arm.robot.kinematics.range
    rng = np.random.default_rng(0)  # restarts must not change from call to call
    spread = rng.normal(scale=0.5, size=(_RESTARTS, len(seed)))
    guesses = np.clip(np.vstack([seed[None], seed + spread]), limits[:, 0], limits[:, 1])
    targets = np.tile(position, (len(guesses), 1))
    q, error = _newton(arm, targets, rotation, guesses)
    inside = np.all((q >= limits[:, 0]) & (q <= limits[:, 1]), axis=1)
    if error.min() > TOLERANCE:
        raise _unreachable(arm, position, error.min(), 0)
    usable = np.flatnonzero((error <= TOLERANCE) & inside)
    if usable.size == 0:
        raise FFGymError(f"TCP position {_text(position)} m is reachable only beyond the joint limits.")
    return q[usable[np.argmin(np.abs(q[usable] - seed).max(axis=1))]]


def _newton(arm: RigidArm, positions: Array, rotation: Array, q: Array) -> tuple[Array, Array]:
    """Newton's iteration on every row at once; returns angles (T, N) and the pose error left (T,)."""
    q = q.copy()
    error = np.full(len(q), np.inf)
    active = np.arange(len(q))
    for _ in range(_MAX_ITERATIONS):
        where, turn, jacobian = arm.pose_and_jacobian(q[active])
        twist = np.concatenate([positions[active] - where, rotation_error(rotation, turn)], axis=1)
        error[active] = np.abs(twist).max(axis=1)
        todo = error[active] > TOLERANCE
        active, twist, jacobian = active[todo], twist[todo], jacobian[todo]
        if active.size == 0:
            break
        step = solve_twist(jacobian, twist)
        length = np.abs(step).max(axis=1, keepdims=True)
        q[active] += step * np.minimum(1.0, _LARGEST_STEP / np.maximum(length, 1e-300))
    return q, error


def solve_twist(jacobian: Array, twist: Array) -> Array:
    """Smallest joint step or speed (T, N) whose TCP twist is `twist` (T, 6), by damped normal equations."""
    gram = jacobian @ jacobian.swapaxes(1, 2) + _DAMPING**2 * np.eye(jacobian.shape[1])
    return (jacobian.swapaxes(1, 2) @ np.linalg.solve(gram, twist[:, :, None]))[:, :, 0]


def rotation_error(wanted: Array, actual: Array) -> Array:
    """Rotation vector [rad] in the world from `actual` (T, 3, 3) to `wanted` (3, 3), exact to third order near zero."""
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


def _check_joint_limits(arm: RigidArm, q: Array) -> None:
    limits = arm.robot.kinematics.range
    outside = np.argwhere((q < limits[:, 0]) | (q > limits[:, 1]))
    if outside.size:
        row, j = (int(i) for i in outside[0])
        low, high = np.degrees(limits[j])
        raise FFGymError(
            f"Joint {arm.robot.joints[j]} would be at {np.degrees(q[row, j]):.1f} deg at sample {row}, must be within "
            f"[{low:.1f}, {high:.1f}] deg. Move the path or the tool orientation."
        )


def _check_singularity(arm: RigidArm, q: Array) -> None:
    condition = np.linalg.cond(arm.jacobian(q))
    worst = int(np.argmax(condition))
    if condition[worst] > MAX_CONDITION:
        raise FFGymError(
            f"The path comes too near a singularity at sample {worst}: Jacobian condition {condition[worst]:.0f}, "
            f"must be below {MAX_CONDITION:.0f}. Move the path or turn the tool."
        )


def _unreachable(arm: RigidArm, position: Array, error: float, sample: int) -> FFGymError:
    return FFGymError(
        f"TCP position {_text(position)} m (sample {sample}) is not reachable with the given tool orientation by "
        f"{arm.robot.name!r}: the nearest pose found misses it by {error:.3g} m or rad."
    )


def _text(position: Array) -> str:
    return "(" + ", ".join(f"{x:.4f}" for x in position) + ")"
