"""What is said of poses and paths that an arm cannot make."""

import numpy as np

from ffgym.errors import FFGymError
from ffgym.robot.arm import RigidArm
from ffgym.robot.inverse_kinematics.goal import Goal
from ffgym.robot.inverse_kinematics.mobility import MAX_CONDITION, any_poses
from ffgym.robot.inverse_kinematics.newton import ROUNDING
from ffgym.types import Array


def unreachable(arm: RigidArm, goal: Goal, q: Array, sample: int) -> FFGymError:
    """Error for one pose that is missed at joint positions `q` (K, N), of which the nearest to it counts."""
    aims = Goal(
        positions=np.broadcast_to(goal.positions, (len(q), 3)),
        rotations=None if goal.rotations is None else np.broadcast_to(goal.rotations, (len(q), 3, 3)),
    )
    misses = aims.miss(arm, q)[0]
    miss = misses[np.argmin(np.abs(misses).max(axis=1))]
    point = f"TCP position {point_text(goal.positions[0])} m (sample {sample})"
    why = _outside(arm, goal.positions[0], point)
    if why is None and goal.rotations is not None:
        why = _twisted(arm, goal.rotations[0], sample)
    return FFGymError(why or f"{point} is not reachable{_by(arm, miss)}.")


def _by(arm: RigidArm, miss: Array) -> str:
    """Who cannot reach a pose, and how near it comes."""
    far = f"{np.linalg.norm(miss[:3]):.3g} m"
    if len(miss) == 3:
        return f" by {arm.robot.name!r}: the nearest position found misses it by {far}"
    turned = f"{np.degrees(np.linalg.norm(miss[3:])):.3g} deg"
    return (
        f" with the given tool orientation by {arm.robot.name!r}, {arm.robot.n_joints} axes: the nearest pose found "
        f"misses it by {far} and {turned}"
    )


def _outside(arm: RigidArm, position: Array, point: str) -> str | None:
    """What is wrong with a position outside the plane or line to which the arm's build confines its TCP."""
    q = any_poses(arm)
    directions, n_free = _span(arm.jacobian(q)[:, :3])
    offset = directions[n_free:] @ (position - arm.tcp_position(q[:1])[0])
    if not np.any(np.abs(offset) > ROUNDING):
        return None
    where = {
        1: f"along the line with direction {_direction(directions[0])}",
        2: f"in the plane with normal {_direction(directions[-1])}",
    }.get(n_free, "not at all")
    return (
        f"{point} cannot be reached by {arm.robot.name!r}: its TCP moves {where} through "
        f"{point_text(arm.tcp_position(q[:1])[0])} m, and the path leaves it by {np.linalg.norm(offset):.3g} m."
    )


def _twisted(arm: RigidArm, rotation: Array, sample: int) -> str | None:
    """What is wrong with an orientation that the arm's build rules out."""
    q = any_poses(arm)
    directions, n_free = _span(arm.jacobian(q)[:, 3:])
    if n_free > 1:
        return None
    turn = rotation @ arm.tcp_pose(q[:1])[1][0].T
    kept = directions[0] if n_free == 1 else None
    cosine = 0.5 * (np.trace(turn) - 1) if kept is None else kept @ turn @ kept
    angle = np.arccos(np.clip(cosine, -1.0, 1.0))
    if angle <= ROUNDING:
        return None
    able = "does not turn its tool" if kept is None else f"turns its tool about {_direction(kept)} only"
    return (
        f"{arm.robot.name!r} {able}; the wanted orientation (sample {sample}) is {np.degrees(angle):.3g} deg away from "
        f"what it can do. Give one that it can, or leave the orientation free."
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
