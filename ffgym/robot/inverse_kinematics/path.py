"""Joint positions for a path of the tool: Newton steps from sample to sample, on one branch."""

import numpy as np

from ffgym.core.errors import FFGymError, check_shape
from ffgym.core.types import Array
from ffgym.robot.dynamics.arm import RigidArm
from ffgym.robot.inverse_kinematics.newton import LARGEST_STEP, MAX_CONDITION, Goal, Posture, newton
from ffgym.robot.inverse_kinematics.poses import check_possible, first_pose, unreachable

_BLOCK = 256


class PathJump(FFGymError):
    """Joints would move so far from one sample to the next that they might be on another branch."""

    def __init__(self, message: str, sample: int) -> None:
        super().__init__(message)
        self.sample = sample


def solve_path(arm: RigidArm, positions: Array, rotation: Array | None, seed: Array) -> Array:
    """Joint positions, shape (T, N), that put the TCP on `positions` with tool0 turned to `rotation`.

    An arm with joints to spare stays as near to the seed as it can, see `Posture`; one that cannot make all motions of
    a tool must meet position and orientation all the same.

    Args:
        arm: the robot.
        positions: TCP positions in the world [m], shape (T, 3); neighbours must be close.
        rotation: orientation of tool0 in the world, shape (3, 3) or (T, 3, 3); None leaves it free.
        seed: joint positions [rad or m], shape (N,), near the branch that is wanted.

    Raises:
        FFGymError: if a pose is unreachable, the path jumps to another branch, comes too near a singularity
            or leaves the joint limits.
    """
    goal = Goal.of(positions, rotation)
    seed = check_shape("seed", seed, (arm.robot.n_joints,))
    q = np.empty((len(goal), len(seed)))
    check_possible(arm, goal)
    posture = Posture.near(arm, seed, turning=rotation is not None)
    last = first_pose(arm, goal.at(slice(1)), posture, sample=0)
    for start in range(0, len(goal), _BLOCK):
        rows = slice(start, start + _BLOCK)
        q[rows] = _follow(arm, goal.at(rows), posture, last, start)
        last = q[rows][-1]
    _check_joint_limits(arm, q)
    # complain where the arm is about to lose one of the motions that it can make elsewhere
    condition = np.linalg.cond(posture.demands(arm.jacobian(q), q)[0])
    worst = int(np.argmax(condition))
    if condition[worst] > MAX_CONDITION:
        raise FFGymError(
            f"The path comes too near a singularity at sample {worst}: Jacobian condition {condition[worst]:.0f}, "
            f"must be below {MAX_CONDITION:.0f}. Move the path or turn the tool."
        )
    return q


def _follow(arm: RigidArm, goal: Goal, posture: Posture, last: Array, start: int) -> Array:
    """Solve a block at once from the pose before it; halve the block until it stays on the branch."""
    q, met = newton(arm, goal, posture, np.tile(last, (len(goal), 1)))
    steps = np.abs(np.diff(np.vstack([last[None], q]), axis=0)).max(axis=1)
    if met.all() and steps.max() <= LARGEST_STEP:
        return q
    if len(goal) == 1:
        if not met[0]:
            raise unreachable(arm, goal, q, start)
        joint = int(np.argmax(np.abs(q[0] - last)))
        raise PathJump(
            f"The path jumps at sample {start}: joint {arm.robot.joints[joint]} would move "
            f"{np.abs(q[0] - last)[joint]:.2f} {arm.robot.kinematics.units[joint]} in one sample. Keep the path "
            f"farther from singularities and on one branch, or sample it more finely.",
            start,
        )
    half = len(goal) // 2
    first = _follow(arm, goal.at(slice(half)), posture, last, start)
    return np.vstack([first, _follow(arm, goal.at(slice(half, None)), posture, first[-1], start + half)])


def _check_joint_limits(arm: RigidArm, q: Array) -> None:
    kinematics = arm.robot.kinematics
    outside = np.argwhere(kinematics.beyond_limits(q))
    if outside.size:
        row, j = (int(i) for i in outside[0])
        slides = kinematics.is_sliding[j]
        unit, factor, digits = ("m", 1.0, 4) if slides else ("deg", 180 / np.pi, 1)
        at, low, high = (f"{x * factor:.{digits}f}" for x in (q[row, j], *kinematics.range[j]))
        raise FFGymError(
            f"Joint {arm.robot.joints[j]} would be at {at} {unit} at sample {row}, must be within [{low}, {high}] "
            f"{unit}. Move the path or the tool orientation."
        )
