"""What is said of poses and paths that an arm cannot make."""

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.robot.dynamics.arm import RigidArm
from ffgym.robot.inverse_kinematics.goal import Goal
from ffgym.robot.inverse_kinematics.mobility import MAX_CONDITION, any_poses, mobility
from ffgym.robot.inverse_kinematics.newton import ROUNDING


def check_possible(arm: RigidArm, goal: Goal) -> None:
    """Check that the arm's build lets its tool move and turn as it is asked to, be it within reach or not.

    Raises:
        FFGymError: if a goal lies outside the plane or line of the TCP, or is turned as the tool cannot be.
    """
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
