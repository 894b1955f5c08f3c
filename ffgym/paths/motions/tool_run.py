"""Moves of the tool in space as joint motion, from rest to rest: legs, rounded corners, stops, bounds."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ffgym.core.errors import FFGymError, errors_at
from ffgym.core.types import Array
from ffgym.paths.curves import SAME, Arc, Curve, Line, Still, arc_through, spline_through
from ffgym.paths.limits import Bounds, MotionLimits, axis_bounds, slope_of, stretches, tool_bounds
from ffgym.paths.motions.rows import ReferencePiece, Step, add_step, rows_along, split_steps
from ffgym.paths.moves import Move, MoveArc, MoveSpline, ToolMove, locate_error
from ffgym.paths.route import (
    SMOOTH,
    Course,
    Leg,
    Route,
    SplineTurn,
    chain_courses,
    even_turn,
    round_corners,
)
from ffgym.paths.timing import time_law
from ffgym.recordings import PhaseKind
from ffgym.robot import RigidArm, solve_path
from ffgym.robot.inverse_kinematics import joint_rates
from ffgym.robot.inverse_kinematics.poses import PathJump

RESOLVED = 0.1
"""Largest change of joint speeds per path speed from one point at which a leg is examined to the next, as a share of
the largest on the leg; chosen: what lies between is then missed by the square of it, which `limits.MARGIN` covers."""
_HALVINGS = 4
"""Largest number of halvings of intervals on which joints seem to jump; chosen: 5 mm become 0.3 mm, in which
only an arm in a singularity moves as far."""
_REFINEMENTS = 12
"""Largest number of halvings of an interval; chosen: 5 mm become 1 um, finer than any path."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ToolRun:
    """A route of the TCP, and which move leads to each of its targets."""

    route: Route
    targets: Array
    """Path length at each target [m], shape (L,)."""
    moves: tuple[Move, ...]
    """One for each target."""
    kinds: tuple[PhaseKind, ...]
    passed: tuple[tuple[Move, float], ...]
    """All moves with the path lengths at their targets, those of a full circle among them."""


def run_tool(arm: RigidArm, run: ToolRun, q: Array, limits: MotionLimits) -> ReferencePiece:
    """Joint motion along the route, as fast as programmed speeds and limits allow, from joint positions `q` (N,)."""
    law = time_law(stretches(*_bounds(arm, run, q, limits)))
    phases = [(move.label, kind) for move, kind in zip(run.moves, run.kinds, strict=True)]
    dt = arm.robot.servo.control_dt
    return rows_along(law, lambda s: _follow(arm, run.route.at(s), q), run.targets, phases, run.passed, dt)


def _follow(arm: RigidArm, course: Course, q: Array) -> tuple[Array, Array, Array]:
    """Solve joint positions along a path from `q` (N,), and their first two derivatives by its length, (T, N)."""
    position, tangent, bend, _ = course.path
    if course.turned is None:
        rows = solve_path(arm, position, None, q)
        return rows, *joint_rates(arm, rows, q, tangent, bend)
    rotation, rate, change = course.turned
    rows = solve_path(arm, position, rotation, q)
    return rows, *joint_rates(arm, rows, q, np.hstack([tangent, rate]), np.hstack([bend, change]))


@dataclass(frozen=True, kw_only=True, eq=False)
class _Examined:
    """A leg at the points of its grid."""

    leg: Leg
    s: Array
    """Arc lengths from its start, increasing, shape (K,)."""
    course: Course
    first: Array
    """Joint positions' derivative by arc length, shape (K, N)."""
    second: Array
    """Their second derivative, shape (K, N)."""


def _bounds(arm: RigidArm, run: ToolRun, q: Array, limits: MotionLimits) -> tuple[list[Array], list[Bounds]]:
    """Arc lengths at which each leg was examined, and bounds on path speed there, from the tool and from the joints."""
    axes = limits.of_joints(arm.robot.kinematics.max_speed)
    legs = _on_one_branch(arm, run, q)
    for _ in range(_REFINEMENTS):
        finer = [_refine(leg.s, leg.first / axes.speed, leg.second / axes.speed) for leg in legs]
        if all(len(s) == len(leg.s) for s, leg in zip(finer, legs, strict=True)):
            break
        legs = _examine(arm, run, finer, q)
    bounds = [
        axis_bounds(
            (leg.first, leg.second, slope_of(leg.second, leg.s)),
            axes,
            tool_bounds(leg.leg.speed, leg.s, leg.course, limits),
        )
        for leg in legs
    ]
    return [leg.s for leg in legs], bounds


def _on_one_branch(arm: RigidArm, run: ToolRun, q: Array) -> list[_Examined]:
    """The legs of a run at the points of their grids, which are closer where joints would seem to jump."""
    grid = [leg.grid() for leg in run.route.legs]
    halvings = [0] * len(grid)
    while True:
        try:
            return _examine(arm, run, grid, q)
        except FFGymError as error:
            jump = error.__cause__
            if not isinstance(jump, PathJump):
                raise
            which = int(np.searchsorted(np.cumsum([len(s) for s in grid]), jump.sample, side="right"))
            if halvings[which] == _HALVINGS:
                raise
            halvings[which] += 1
            grid[which] = np.sort(np.concatenate([grid[which], 0.5 * (grid[which][:-1] + grid[which][1:])]))


def _examine(arm: RigidArm, run: ToolRun, grid: Sequence[Array], q: Array) -> list[_Examined]:
    """Examine the legs of a run at the points of a grid."""
    courses = [leg.at(s) for leg, s in zip(run.route.legs, grid, strict=True)]
    try:
        _, first, second = _follow(arm, chain_courses(courses), q)
    except FFGymError as error:
        raise locate_error(_find_culprit(arm, run, courses, q), str(error)) from error
    cuts = np.cumsum([len(s) for s in grid])[:-1]
    return [
        _Examined(leg=leg, s=s, course=course, first=d1, second=d2)
        for leg, s, course, d1, d2 in zip(
            run.route.legs, grid, courses, np.split(first, cuts), np.split(second, cuts), strict=True
        )
    ]


def _refine(s: Array, first: Array, second: Array) -> Array:
    """Refine a grid by a new point in the middle of each interval over which one of two slopes (K, N) changes much."""
    largest = float(np.abs(first).max())
    scales = (largest, max(float(np.abs(second).max()), largest / s[-1]))  # a straight path has no second slope
    changes = [np.abs(np.diff(x, axis=0)).max(axis=1) / scale for x, scale in zip((first, second), scales, strict=True)]
    coarse = np.max(changes, axis=0) > RESOLVED
    return np.sort(np.concatenate([s, 0.5 * (s[:-1] + s[1:])[coarse]]))


def _find_culprit(arm: RigidArm, run: ToolRun, courses: Sequence[Course], q: Array) -> Move:
    """Find the move whose leg is the first that cannot be followed."""
    middles = run.route.ends - [0.5 * leg.curve.length for leg in run.route.legs]
    for middle, course in zip(middles, courses, strict=True):
        try:
            q = _follow(arm, course, q)[0][-1]
        except FFGymError:
            return run.moves[int(np.searchsorted(run.targets, middle * (1 - 1e-9)))]
    return run.moves[0]


def tool_runs(moves: Sequence[ToolMove], position: Array, rotation: Array | None) -> tuple[list[ToolRun], list[str]]:
    """Runs from rest to rest through the targets of `moves`, and notes where the robot stops although it need not.

    They start at `position` (3,) [m] with tool0 turned to `rotation` (3, 3); None leaves it free all along.
    """
    steps: list[Step] = []
    for move in moves:
        with errors_at(move.where):
            leg = _leg(move, position, rotation)
        add_step(steps, move, leg)
        target = move.through[-1] if isinstance(move, MoveSpline) else move.to
        position = target.position
        if rotation is not None and target.rotation is not None:
            rotation = target.rotation
    groups, notes = split_steps(steps)
    return [_run(group) for group in groups], notes


def _leg(move: ToolMove, position: Array, rotation: Array | None) -> Leg | None:
    """Leg from a pose to the target of `move`; None if the tool is there already."""
    if isinstance(move, MoveSpline):
        return _spline_leg(move, position, rotation)
    target = move.to.position
    end = rotation if rotation is None or move.to.rotation is None else move.to.rotation
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
    rotations = np.stack([rotation, *(rotation if pose.rotation is None else pose.rotation for pose in poses)])
    return Leg(curve=curve, speed=move.speed, turning=SplineTurn(knots=curve.knots, rotations=rotations))


def _run(steps: Sequence[Step]) -> ToolRun:
    """Route of some steps; consecutive arcs that together make a full circle are one phase, other moves keep theirs."""
    legs = [step.leg for step in steps]
    route, targets = round_corners(legs, [step.move.zone.radius for step in steps[:-1]])
    last: list[int] = []  # the step that each phase ends with
    kinds: list[PhaseKind] = []
    i = 0
    while i < len(legs):
        count = _arcs_of_circle([leg.curve for leg in legs[i:]])
        i += max(count, 1)
        last.append(i - 1)
        kinds.append("circle" if count else "motion")
    return ToolRun(
        route=route,
        targets=targets[last],
        moves=tuple(steps[i].move for i in last),
        kinds=tuple(kinds),
        passed=tuple((step.move, float(target)) for step, target in zip(steps, targets, strict=True)),
    )


def _arcs_of_circle(curves: Sequence[Curve]) -> int:
    """Count the first curves that make one full circle; 0 if they do not."""
    one, angle = curves[0], 0.0
    for count, other in enumerate(curves, start=1):
        if not isinstance(one, Arc) or not isinstance(other, Arc):
            return 0
        apart = float(np.linalg.norm(one.centre - other.centre)) / one.radius
        tilt = float(np.linalg.norm(np.cross(one.first, one.second) - np.cross(other.first, other.second)))
        if max(apart, tilt, abs(other.radius / one.radius - 1)) > SMOOTH:
            return 0
        angle += other.angle
        if abs(angle - 2 * np.pi) <= SMOOTH:
            return count
    return 0
