"""Joint positions for one pose of the tool or along a path of it, and errors about poses out of reach."""

import numpy as np

from ffgym.core.errors import FFGymError, check_shape
from ffgym.core.types import Array, BoolArray
from ffgym.robot.dynamics.arm import RigidArm
from ffgym.robot.inverse_kinematics.newton import (
    LARGEST_STEP,
    MAX_CONDITION,
    ROUNDING,
    Goal,
    Posture,
    any_poses,
    mobility,
    newton,
)
from ffgym.robot.parts import LIMIT_ROUNDING


def check_possible(arm: RigidArm, goal: Goal) -> None:
    """Check that the arm's build lets its tool move and turn as it is asked to, be it within reach or not."""
    position, rotation, jacobian = arm.pose_and_jacobian(any_poses(arm))
    moves, n_moves = _span(jacobian[:, :3])
    outside = np.linalg.norm((goal.positions - position[0]) @ moves[n_moves:].T, axis=1)
    worst = int(np.argmax(outside))
    if outside[worst] > ROUNDING:
        where = {
            1: f"moves along the line with direction {_direction(moves[0])}",
            2: f"moves in the plane with normal {_direction(moves[2])}",
        }.get(n_moves, "does not move from where it is,")
        raise FFGymError(
            f"The TCP of {arm.robot.name!r} {where} through {point_text(position[0])} m; it would have to leave it by "
            f"{outside[worst]:.3g} m for sample {worst}, {point_text(goal.positions[worst])} m."
        )
    if goal.rotations is not None:
        _check_turn(arm, goal.rotations @ rotation[0].T, *_span(jacobian[:, 3:]))


def _check_turn(arm: RigidArm, change: Array, turns: Array, n_turns: int) -> None:
    """Check turns (T, 3, 3) of the tool from an orientation that it can have."""
    if n_turns > 1:  # axes that turn each other may reach any orientation; the search will tell
        return
    if n_turns == 1:
        cosine, able = turns[0] @ change @ turns[0], f"turns its tool about {_direction(turns[0])} only"
    else:
        cosine, able = 0.5 * (np.trace(change, axis1=1, axis2=2) - 1), "does not turn its tool"
    away = np.arccos(np.clip(cosine, -1.0, 1.0))
    worst = int(np.argmax(away))
    if away[worst] > ROUNDING:
        raise FFGymError(
            f"{arm.robot.name!r} {able}; the orientation of sample {worst} is {np.degrees(away[worst]):.3g} deg away "
            f"from what it can do. Give one that it can, or leave the orientation free."
        )


def unreachable(arm: RigidArm, goal: Goal, q: Array, sample: int | None = None) -> FFGymError:
    """Error for one pose, perhaps a `sample` of a path, that is missed at all of the joint positions `q` (K, N)."""
    misses = goal.at(np.zeros(len(q), dtype=np.intp)).miss(arm, q)[0]
    miss = misses[np.argmin(np.abs(misses).max(axis=1))]
    aim, how, way_out = "position", "", ""
    far = f"{np.linalg.norm(miss[:3]):.3g} m"
    if goal.rotations is not None:
        aim, how = "pose", " with the given tool orientation"
        far += f" and {np.degrees(np.linalg.norm(miss[3:])):.3g} deg"
        n_motions = mobility(arm, turning=True)
        if n_motions < 6:
            way_out = (
                f" The arm has {n_motions} of the 6 motions of a tool; leave its orientation free where it may be."
            )
    where = "" if sample is None else f" (sample {sample})"
    return FFGymError(
        f"TCP position {point_text(goal.positions[0])} m{where} is not reachable{how} by {arm.robot.name!r}: the "
        f"nearest {aim} found misses it by {far}.{way_out}"
    )


def _span(jacobian: Array) -> tuple[Array, int]:
    """Orthonormal directions (3, 3) of motion at many poses (K, 3, N), and how many of them are possible at all."""
    _, sizes, directions = np.linalg.svd(jacobian.swapaxes(1, 2).reshape(-1, 3), full_matrices=False)
    return directions, int(np.sum(sizes > sizes[0] / MAX_CONDITION)) if sizes[0] > 0 else 0


def point_text(position: Array) -> str:
    """Position [m] as text."""
    return "(" + ", ".join(f"{x:.4f}" for x in position) + ")"


def _direction(axis: Array) -> str:
    """Direction as text; its sign says nothing, so that its largest entry is made positive."""
    upright = axis * np.sign(axis[np.argmax(np.abs(axis))])
    return "(" + ", ".join(f"{x + 0.0:.4g}" for x in np.round(upright, 4)) + ")"


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
    """Find all different joint positions for a pose within the joint limits, shape (K, N), nearest to `seed` first.

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
    """
    # the posture, and random poses around it within the limits, always the same
    spread = np.random.default_rng(0).normal(scale=_SPREAD, size=(_RESTARTS, arm.robot.n_joints))
    around = np.vstack([posture.anchor[None], posture.anchor + spread])
    q, met = _search(arm, goal, posture, np.clip(around, *arm.robot.kinematics.range.T))
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
    """Check the goal of one pose, and choose the posture near it."""
    goal = Goal.of(check_shape("position", position, (3,))[None], rotation)
    check_possible(arm, goal)
    anchor = check_shape("seed", seed, (arm.robot.n_joints,))
    return goal, Posture.near(arm, anchor, turning=goal.rotations is not None)


def _search(arm: RigidArm, goal: Goal, posture: Posture, guesses: Array) -> tuple[Array, BoolArray]:
    """Iterate from `guesses` (K, N) for one pose, hinges turned back into their ranges; tell which meet it."""
    aims, kinematics = goal.at(np.zeros(len(guesses), dtype=np.intp)), arm.robot.kinematics
    q, met = newton(arm, aims, posture, guesses)
    low, high = kinematics.range.T
    turns = np.ceil(np.maximum(low - q, 0.0) / (2 * np.pi)) - np.ceil(np.maximum(q - high, 0.0) / (2 * np.pi))
    turned = np.where(kinematics.beyond_limits(q) & ~kinematics.is_sliding, q + 2 * np.pi * turns, q)
    if posture.n_spare == 0:
        return turned, met
    return newton(arm, aims, posture, turned)  # what is nearest to the posture, is so no more after a whole turn


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
