"""From moves of the tool to runs: legs between targets, corners that are rounded, and stops where they cannot be."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.paths.curves import SAME, Arc, Curve, Line, Still, arc_through
from ffgym.paths.motions.tool_run import ToolRun
from ffgym.paths.moves import Move, MoveArc, MoveLinear, MoveSpline, Pose, located
from ffgym.paths.polynomial_curve import spline_through
from ffgym.paths.route import SHARPEST, SMOOTH, Leg, corner_angle, rounded
from ffgym.paths.turning import SplineTurn, even_turn
from ffgym.recordings import PhaseKind

ToolMove = MoveLinear | MoveArc | MoveSpline
"""Moves whose path is given in space."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Step:
    """A move of the tool and the leg that it makes."""

    move: ToolMove
    leg: Leg
    stops: bool
    """Whether the robot is to rest at the target."""


def tool_runs(moves: Sequence[ToolMove], position: Array, rotation: Array | None) -> tuple[list[ToolRun], list[str]]:
    """Runs from rest to rest through the targets of `moves`, and notes where the robot stops although it need not.

    Args:
        moves: that follow each other; all but the last may have zones.
        position: TCP where they start [m], shape (3,).
        rotation: orientation of tool0 there, shape (3, 3); None leaves it free all along.

    Raises:
        FFGymError: if a move cannot be made; the message begins with its place.
    """
    steps = []
    for move in moves:
        try:
            leg = _leg(move, position, rotation)
        except FFGymError as error:
            raise located(move, str(error)) from error
        if leg is not None:
            steps.append(Step(move=move, leg=leg, stops=move.zone.stops))
        elif steps and move.zone.stops:
            steps[-1] = replace(steps[-1], stops=True)
        target = move.through[-1] if isinstance(move, MoveSpline) else move.to
        position = target.position
        rotation = None if rotation is None else _turned(target, rotation)
    groups, notes = _split(steps)
    return [_run(group) for group in groups], notes


def _turned(pose: Pose, before: Array) -> Array:
    return before if pose.rotation is None else pose.rotation


def _leg(move: ToolMove, position: Array, rotation: Array | None) -> Leg | None:
    """Leg from a pose to the target of `move`; None if the tool is there already."""
    if isinstance(move, MoveSpline):
        return _spline_leg(move, position, rotation)
    target = move.to.position
    end = None if rotation is None else _turned(move.to, rotation)
    if isinstance(move, MoveArc):
        curve: Curve = arc_through(position, move.via, target)
    elif np.linalg.norm(target - position) > SAME:
        curve = Line(start=position, end=target)
    else:
        angle = 0.0 if rotation is None or end is None else float(np.linalg.norm(even_turn(rotation, end, 1.0).rate))
        if angle <= SAME:
            return None
        curve = Still(point=position, angle=angle)
    turning = None if rotation is None or end is None else even_turn(rotation, end, curve.length)
    return Leg(curve=curve, speed=move.speed, turning=turning)


def _spline_leg(move: MoveSpline, position: Array, rotation: Array | None) -> Leg:
    poses = list(move.through)
    if np.linalg.norm(poses[0].position - position) <= SAME:
        poses = poses[1:]
    points = np.vstack([position[None], *(pose.position[None] for pose in poses)])
    if not np.all(np.linalg.norm(np.diff(points, axis=0), axis=1) > SAME):
        raise FFGymError(f"The points of a spline must be more than {SAME} m apart from one to the next.")
    curve = spline_through(points, closed=move.closed)
    if rotation is None:
        return Leg(curve=curve, speed=move.speed)
    rotations = np.stack([rotation, *(_turned(pose, rotation) for pose in poses)])
    return Leg(curve=curve, speed=move.speed, turning=SplineTurn(knots=curve.knots, rotations=rotations))


def _split(steps: Sequence[Step]) -> tuple[list[list[Step]], list[str]]:
    """Groups of steps between which the robot stops, and a note for each stop that was not asked for."""
    groups: list[list[Step]] = [[step] for step in steps[:1]]
    notes = []
    for before, after in pairwise(steps):
        why = _no_corner(before, after)
        if before.stops or why:
            groups.append([after])
        else:
            groups[-1].append(after)
        if why and not before.stops:
            notes.append(str(located(before.move, f"the robot stops at {before.move.label!r}, because {why}")))
    return groups, notes


def _no_corner(before: Step, after: Step) -> str:
    """Why the path cannot go round the corner between two steps; empty if it can."""
    steps = (before, after)
    if any(isinstance(step.move, MoveSpline) for step in steps):
        return "a spline starts and ends at rest"
    if any(isinstance(step.leg.curve, Still) for step in steps):
        return "the tool turns on the spot"
    if corner_angle(before.leg.curve, after.leg.curve) > SHARPEST:
        return "the path turns back there"
    return ""


def _run(steps: Sequence[Step]) -> ToolRun:
    legs = [step.leg for step in steps]
    route, targets = rounded(legs, [step.move.zone.radius for step in steps[:-1]])
    moves, targets, kinds = _with_circles([step.move for step in steps], legs, targets)
    return ToolRun(route=route, targets=targets, moves=moves, kinds=kinds)


def _with_circles(
    moves: Sequence[Move], legs: Sequence[Leg], targets: Array
) -> tuple[tuple[Move, ...], Array, tuple[PhaseKind, ...]]:
    """One phase for consecutive arcs that together make a full circle; other moves keep theirs."""
    kept: list[tuple[Move, float, PhaseKind]] = []
    i = 0
    while i < len(legs):
        count = _arcs_of_circle(legs[i:])
        kind: PhaseKind = "circle" if count else "motion"
        i += max(count, 1)
        kept.append((moves[i - 1], float(targets[i - 1]), kind))
    return tuple(k[0] for k in kept), np.array([k[1] for k in kept]), tuple(k[2] for k in kept)


def _arcs_of_circle(legs: Sequence[Leg]) -> int:
    """How many of the first legs make one full circle; 0 if they do not."""
    first, angle = legs[0].curve, 0.0
    for count, leg in enumerate(legs, start=1):
        if not isinstance(first, Arc) or not isinstance(leg.curve, Arc) or not _same_circle(first, leg.curve):
            return 0
        angle += leg.curve.angle
        if abs(angle - 2 * np.pi) <= SMOOTH:
            return count
    return 0


def _same_circle(one: Arc, other: Arc) -> bool:
    apart = float(np.linalg.norm(one.centre - other.centre)) / one.radius
    tilt = float(np.linalg.norm(np.cross(one.first, one.second) - np.cross(other.first, other.second)))
    return max(apart, tilt, abs(other.radius / one.radius - 1)) <= SMOOTH
