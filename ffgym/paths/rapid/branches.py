"""Which of its branches the arm takes to a target: what robconf asks for, where it can."""

from dataclasses import replace

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.paths.moves import Move, MoveJoint, Pose, located
from ffgym.paths.rapid.interpreter import Execution
from ffgym.paths.rapid.targets import Configuration
from ffgym.robot import RigidArm, RobotDescription, pose_solutions, solve_pose

_AXES = [0, 3, 5]
"""Joints whose quarter turns cf1, cf4 and cf6 count."""

_EDGE = 1e-3
"""How far beyond a quarter turn an axis may be [rad]; chosen: targets are rounded, and axes often stand at 0 deg."""


def on_branches(arm: RigidArm, execution: Execution) -> tuple[tuple[Move, ...], tuple[str, ...]]:
    """Moves whose joint moves end on the branches that their targets ask for, and notes where they cannot.

    robconf describes arms of six hinges; other arms take the nearest branch. Where no solution has the quarter turns
    that are asked for, the move keeps its pose, so that the nearest branch is taken, and a note says so.

    Args:
        arm: the execution's robot.
        execution: moves and configurations.

    Raises:
        FFGymError: if a target is out of reach; the message begins with the move's place.
    """
    moves, notes = list(execution.moves), []
    if arm.robot.n_joints != 6 or np.any(arm.robot.kinematics.is_sliding):
        return execution.moves, ()
    q = _start(arm.robot)
    for i, (move, wanted) in enumerate(zip(execution.moves, execution.configurations, strict=True)):
        if isinstance(move, MoveJoint) and not isinstance(move.to, Pose):
            q = move.to
        elif isinstance(move, MoveJoint) and isinstance(move.to, Pose) and wanted is not None:
            found = _solved(arm, move, move.to, wanted, q)
            if found is None:
                notes.append(
                    str(located(move, f"no solution for {move.label} has {_text(wanted)}; the nearest is taken"))
                )
            else:
                q = found
                moves[i] = replace(move, to=q)
    return tuple(moves), tuple(notes)


def _start(robot: RobotDescription) -> Array:
    """Joint positions from which the first target is sought."""
    return robot.kinematics.range.mean(axis=1) if robot.work_area is None else robot.work_area.home


def _solved(arm: RigidArm, move: Move, pose: Pose, wanted: Configuration, near: Array) -> Array | None:
    """Joint positions (N,) for a pose with the quarter turns that are wanted, the nearest; None if there are none."""
    try:
        nearest = solve_pose(arm, pose.position, pose.rotation, near)
        if _has(nearest, wanted):
            return nearest
        every = pose_solutions(arm, pose.position, pose.rotation, near)
    except FFGymError as error:
        raise located(move, str(error)) from error
    return next((q for q in every if _has(q, wanted)), None)


def _has(q: Array, wanted: Configuration) -> bool:
    """Whether joint positions (N,) have quarter turns, as good as targets are rounded."""
    low = np.array(wanted) * np.pi / 2
    return bool(np.all((q[_AXES] > low - _EDGE) & (q[_AXES] < low + np.pi / 2 + _EDGE)))


def _text(configuration: Configuration) -> str:
    return "robconf cf1, cf4, cf6 = " + ", ".join(str(quarter) for quarter in configuration)
