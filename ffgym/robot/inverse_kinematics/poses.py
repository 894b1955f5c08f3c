"""Joint positions for one pose of the tool."""

import numpy as np

from ffgym.core.errors import FFGymError, check_shape
from ffgym.core.types import Array, BoolArray
from ffgym.robot.dynamics.arm import RigidArm
from ffgym.robot.inverse_kinematics.goal import Goal
from ffgym.robot.inverse_kinematics.mobility import any_poses
from ffgym.robot.inverse_kinematics.newton import newton
from ffgym.robot.inverse_kinematics.posture import Posture
from ffgym.robot.inverse_kinematics.refusals import check_possible, point_text, unreachable
from ffgym.robot.parts import LIMIT_ROUNDING

_RESTARTS = 50
_SPREAD = 0.5
"""Standard deviation [rad or m] of the restarts around a seed."""
_SEARCHES = 400
"""Random poses from which all solutions are searched; chosen: it found all eight of the built-in robot (see tests)."""
_SAME = 1e-6
"""Joint positions [rad or m] nearer than this are one solution: far above the tolerance, far below two branches."""


def solve_pose(arm: RigidArm, position: Array, rotation: Array | None, seed: Array) -> Array:
    """Joint positions, shape (N,), that put the TCP at `position` with tool0 turned to `rotation`.

    Args:
        arm: the robot.
        position: TCP in the world [m], shape (3,).
        rotation: orientation of tool0 in the world, shape (3, 3); None leaves it free.
        seed: joint positions [rad or m], shape (N,); of the solutions found around it, the nearest is returned, and
            where there is none, the nearest of those found anywhere.

    Raises:
        FFGymError: if the pose is unreachable, or reachable only beyond the joint limits.
    """
    goal, posture = _request(arm, position, rotation, seed)
    return first_pose(arm, goal, posture, anywhere=True)


def pose_solutions(arm: RigidArm, position: Array, rotation: Array | None, seed: Array) -> Array:
    """All different joint positions found for a pose within the joint limits, shape (K, N), nearest to `seed` first.

    Hinges that can turn on count with every whole turn that their limits allow. Of an arm with joints to spare, which
    has infinitely many, these are examples.

    Args:
        arm: the robot.
        position: TCP in the world [m], shape (3,).
        rotation: orientation of tool0 in the world, shape (3, 3); None leaves it free.
        seed: joint positions [rad or m], shape (N,).

    Raises:
        FFGymError: if there is none.
    """
    goal, posture = _request(arm, position, rotation, seed)
    nearest = first_pose(arm, goal, posture, anywhere=True)
    q, met = _search(arm, goal, posture, any_poses(arm, _SEARCHES))
    within = met & ~arm.robot.kinematics.beyond_limits(q).any(axis=1)
    found = _different(arm, np.vstack([nearest[None], q[within]]))
    every = np.vstack([_whole_turns(arm, solution) for solution in found])
    return every[np.argsort(np.abs(every - posture.anchor).max(axis=1), kind="stable")]


def first_pose(
    arm: RigidArm, goal: Goal, posture: Posture, *, anywhere: bool = False, sample: int | None = None
) -> Array:
    """Joint positions (N,) within the limits for the one pose of `goal`, the nearest to the posture that is found.

    The search begins at the posture and at random poses around it, and goes on `anywhere` only if these lead nowhere.
    `sample` is for messages.

    Raises:
        FFGymError: if nothing is found.
    """
    q, met = _search(arm, goal, posture, _around(arm, posture.anchor))
    beyond = arm.robot.kinematics.beyond_limits(q).any(axis=1)
    if anywhere and not np.any(met & ~beyond):
        q, met = _search(arm, goal, posture, any_poses(arm, _SEARCHES))
        beyond = arm.robot.kinematics.beyond_limits(q).any(axis=1)
    if not met.any():
        raise unreachable(arm, goal, q, sample)
    found = q[met & ~beyond]
    if len(found) == 0:
        raise FFGymError(f"TCP position {point_text(goal.positions[0])} m is reachable only beyond the joint limits.")
    nearest: Array = found[np.argmin(np.abs(found - posture.anchor).max(axis=1))]
    return nearest


def _request(arm: RigidArm, position: Array, rotation: Array | None, seed: Array) -> tuple[Goal, Posture]:
    """Checked goal of one pose, and the posture to be near to."""
    goal = Goal.of(check_shape("position", position, (3,))[None], rotation)
    check_possible(arm, goal)
    anchor = check_shape("seed", seed, (arm.robot.n_joints,))
    return goal, Posture.near(arm, anchor, turning=goal.rotations is not None)


def _around(arm: RigidArm, seed: Array) -> Array:
    """The seed, and random poses around it, within the limits, always the same, shape (K, N)."""
    low, high = arm.robot.kinematics.range.T
    spread = np.random.default_rng(0).normal(scale=_SPREAD, size=(_RESTARTS, len(seed)))
    return np.clip(np.vstack([seed[None], seed + spread]), low, high)


def _search(arm: RigidArm, goal: Goal, posture: Posture, guesses: Array) -> tuple[Array, BoolArray]:
    """Where `guesses` (K, N) lead to for one pose, hinges turned back into their ranges, and whether they meet it."""
    aims = goal.at(np.zeros(len(guesses), dtype=np.intp))
    q, met = newton(arm, aims, posture, guesses)
    turned = _turned_back(arm, q)
    if posture.n_spare == 0:
        return turned, met
    return newton(arm, aims, posture, turned)  # what is nearest to the posture, is so no more after a whole turn


def _turned_back(arm: RigidArm, q: Array) -> Array:
    """Joint positions (T, N) of the same poses with hinges beyond a limit turned back by whole turns."""
    kinematics = arm.robot.kinematics
    low, high = kinematics.range.T
    turns = np.ceil(np.maximum(low - q, 0.0) / (2 * np.pi)) - np.ceil(np.maximum(q - high, 0.0) / (2 * np.pi))
    return np.where(kinematics.beyond_limits(q) & ~kinematics.is_sliding, q + 2 * np.pi * turns, q)


def _whole_turns(arm: RigidArm, q: Array) -> Array:
    """All joint positions (K, N) of the pose of `q` (N,) that differ by whole turns, within the limits; may be none."""
    kinematics = arm.robot.kinematics
    low, high = kinematics.range.T
    first = np.where(kinematics.is_sliding, 0, np.ceil((low - LIMIT_ROUNDING - q) / (2 * np.pi)))
    last = np.where(kinematics.is_sliding, 0, np.floor((high + LIMIT_ROUNDING - q) / (2 * np.pi)))
    turns = np.meshgrid(*(np.arange(a, b + 1) for a, b in zip(first, last, strict=True)), indexing="ij")
    every = q + 2 * np.pi * np.stack([axis.ravel() for axis in turns], axis=1)
    return every[~kinematics.beyond_limits(every).any(axis=1)]


def _different(arm: RigidArm, q: Array) -> list[Array]:
    """Rows of `q` (T, N) that are not the same pose of the arm as one before, whole turns of hinges set aside."""
    slides = arm.robot.kinematics.is_sliding
    kept: list[Array] = []
    for row in q:
        apart = [row - other for other in kept]
        apart = [np.where(slides, x, x - 2 * np.pi * np.round(x / (2 * np.pi))) for x in apart]
        if all(np.abs(x).max() > _SAME for x in apart):
            kept.append(row)
    return kept
