"""Moves between targets as one joint reference: what a controller's motion planner does."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ffgym.core.errors import FFGymError, check_number, check_shape
from ffgym.core.types import Array
from ffgym.paths.circles import DWELL
from ffgym.paths.limits import MotionLimits
from ffgym.paths.motions.motion import Motion
from ffgym.paths.motions.planner import Planner, space_of
from ffgym.paths.motions.rows import APART, Rows, joined, rest
from ffgym.paths.moves import Move, MoveArc, MoveJoint, MoveLinear, MoveSpline, Pose, located
from ffgym.robot import RigidArm


def compose(
    arm: RigidArm,
    moves: Sequence[Move],
    *,
    start: Array | None = None,
    limits: MotionLimits | None = None,
    dwell: float = DWELL,
    name: str = "moves",
) -> Motion:
    """Joint reference that carries out moves one after the other, from rest to rest.

    Corners with a zone are rounded, in space between moves of the tool and in joint space between moves of the joints.
    The robot stops where a move of the joints meets one of the tool, around splines and where the tool turns on the
    spot; notes say where that was not asked for. What ends between two samples is held until the next one.

    Args:
        arm: the robot.
        moves: one or more.
        start: joint positions at the start, link side [rad or m], shape (N,); None starts at the first target.
        limits: of speed, acceleration and jerk, beside the programmed speeds; None takes the defaults.
        dwell: rest before the first and after the last move [s], >= 0; a motion that brings its own rests gets none.
        name: name of the motion.

    Raises:
        FFGymError: if a move cannot be made; the message begins with the move's `where`.
    """
    check_number("dwell", dwell, unit="s", low=0.0)
    if not moves:
        raise FFGymError(f"Motion {name!r} has no moves; give at least one.")
    labelled = [move if move.label else replace(move, label=f"move {i}") for i, move in enumerate(moves, start=1)]
    q = None if start is None else check_shape("start", start, (arm.robot.n_joints,))
    planner = Planner(arm=arm, limits=limits or MotionLimits(), free=_orientation_is_free(arm, labelled), q=q)
    groups = _groups(labelled)
    for group in groups:
        planner.plan(group)
    pieces = _with_rests(planner.pieces, planner.q, dwell, arm.robot.servo.control_dt)
    return Motion(reference=joined(name, arm.robot, pieces), notes=(*planner.notes, *_stops(groups)))


def _groups(moves: Sequence[Move]) -> list[list[Move]]:
    """Moves that follow each other and are planned together: of the tool, of the joints, or any other one alone."""
    groups: list[list[Move]] = []
    for move in moves:
        space = space_of(move)
        if space and groups and space_of(groups[-1][-1]) == space:
            groups[-1].append(move)
        else:
            groups.append([move])
    return groups


def _stops(groups: Sequence[Sequence[Move]]) -> list[str]:
    """Notes on zones at which the robot stops all the same, because what comes next is planned on its own."""
    return [
        str(
            located(group[-1], f"the robot stops at {group[-1].label!r}, because a corner joins moves of one kind only")
        )
        for group in groups[:-1]
        if space_of(group[-1]) and not group[-1].zone.stops
    ]


def _poses(move: Move) -> list[Pose]:
    if isinstance(move, MoveSpline):
        return list(move.through)
    return [move.to] if isinstance(move, MoveLinear | MoveArc | MoveJoint) and isinstance(move.to, Pose) else []


def _orientation_is_free(arm: RigidArm, moves: Sequence[Move]) -> bool:
    """Whether nobody says how the tool is to be turned: neither the work area nor any target."""
    area = arm.robot.work_area
    given = any(pose.rotation is not None for move in moves for pose in _poses(move))
    return not given and (area is None or area.tool_rotation is None)


def _with_rests(pieces: Sequence[Rows], q: Array | None, dwell: float, dt: float) -> list[Rows]:
    """Pieces with a rest before and after, unless a rest is there already or the robot is moving."""
    if not pieces:  # the only move said where to be
        assert q is not None
        return [rest(q, max(dwell, dt), dt, "rest 0")]
    rows = list(pieces)
    if dwell > 0 and rows[0].phases[0].kind != "standstill" and np.abs(rows[0].dq[0]).max() <= APART:
        rows.insert(0, rest(rows[0].q[0], dwell, dt, "rest 0"))
    if dwell > 0 and rows[-1].phases[-1].kind != "standstill" and np.abs(rows[-1].dq[-1]).max() <= APART:
        rows.append(rest(rows[-1].q[-1], dwell, dt, "rest 1"))
    return rows
