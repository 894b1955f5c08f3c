"""Moves of the tool in space, from rest to rest, as joint motion."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.paths.bounds import Bounds, axis_bounds, slope_of, tool_bounds
from ffgym.paths.limits import MotionLimits
from ffgym.paths.motions.rows import Rows, phases_at, sample_times
from ffgym.paths.moves import Move, located
from ffgym.paths.pacing import stretches
from ffgym.paths.route import Course, Leg, Route, chained
from ffgym.paths.timing import time_law
from ffgym.recordings import PhaseKind
from ffgym.robot import RigidArm, solve_path
from ffgym.robot.inverse_kinematics import joint_rates
from ffgym.robot.inverse_kinematics.path import PathJump

RESOLVED = 0.1
"""Largest change of joint speeds per path speed from one point at which a leg is examined to the next, as a share of
the largest on the leg; chosen: what lies between is then missed by the square of it, which `bounds.MARGIN` covers."""
_HALVINGS = 4
"""How often the intervals of a leg may be halved on which joints seem to jump; chosen: 5 mm become 0.3 mm, in which
only an arm in a singularity moves as far."""
_REFINEMENTS = 12
"""How often an interval may be halved; chosen: 5 mm become 1 um, below which nobody draws a path."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ToolRun:
    """A route of the TCP, and which move leads to each of its targets."""

    route: Route
    targets: Array
    """Path length at each target [m], shape (L,)."""
    moves: tuple[Move, ...]
    """One for each target."""
    kinds: tuple[PhaseKind, ...]


def run_tool(arm: RigidArm, run: ToolRun, q: Array, limits: MotionLimits) -> Rows:
    """Joint motion along the route, as fast as programmed speeds and limits allow, from joint positions `q` (N,).

    Raises:
        FFGymError: if the arm cannot follow the route; the message begins with the place of the move.
    """
    law = time_law(stretches(*_bounds(arm, run, q, limits)))
    t = sample_times(law, arm.robot.servo.control_dt)
    s, speed, acceleration = law.at(t)
    q_rows, first, second = _followed(arm, run.route.at(s), q)
    return Rows(
        q=q_rows,
        dq=first * speed[:, None],
        ddq=first * acceleration[:, None] + second * speed[:, None] ** 2,
        phases=phases_at(law, run.targets, [move.label for move in run.moves], run.kinds, float(t[-1])),
    )


def _followed(arm: RigidArm, course: Course, q: Array) -> tuple[Array, Array, Array]:
    """Joint positions along a path that starts at `q` (N,), and their first two derivatives by its length, (T, N)."""
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
        finer = [_refined(leg.s, leg.first / axes.speed, leg.second / axes.speed) for leg in legs]
        if all(len(s) == len(leg.s) for s, leg in zip(finer, legs, strict=True)):
            break
        legs = _examined(arm, run, finer, q)
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
            return _examined(arm, run, grid, q)
        except FFGymError as error:
            jump = error.__cause__
            if not isinstance(jump, PathJump):
                raise
            which = int(np.searchsorted(np.cumsum([len(s) for s in grid]), jump.sample, side="right"))
            if halvings[which] == _HALVINGS:
                raise
            halvings[which] += 1
            grid[which] = np.sort(np.concatenate([grid[which], 0.5 * (grid[which][:-1] + grid[which][1:])]))


def _examined(arm: RigidArm, run: ToolRun, grid: Sequence[Array], q: Array) -> list[_Examined]:
    """The legs of a run at the points of a grid."""
    courses = [leg.at(s) for leg, s in zip(run.route.legs, grid, strict=True)]
    try:
        _, first, second = _followed(arm, chained(courses), q)
    except FFGymError as error:
        raise located(_blamed(arm, run, courses, q), str(error)) from error
    cuts = np.cumsum([len(s) for s in grid])[:-1]
    return [
        _Examined(leg=leg, s=s, course=course, first=d1, second=d2)
        for leg, s, course, d1, d2 in zip(
            run.route.legs, grid, courses, np.split(first, cuts), np.split(second, cuts), strict=True
        )
    ]


def _refined(s: Array, first: Array, second: Array) -> Array:
    """Grid with a new point in the middle of each interval over which one of two slopes (K, N) changes much."""
    largest = float(np.abs(first).max())
    scales = (
        largest,
        max(float(np.abs(second).max()), largest / s[-1]),
    )  # a straight path has no second slope to resolve
    changes = [np.abs(np.diff(x, axis=0)).max(axis=1) / scale for x, scale in zip((first, second), scales, strict=True)]
    coarse = np.max(changes, axis=0) > RESOLVED
    return np.sort(np.concatenate([s, 0.5 * (s[:-1] + s[1:])[coarse]]))


def _blamed(arm: RigidArm, run: ToolRun, courses: Sequence[Course], q: Array) -> Move:
    """The move whose leg is the first that cannot be followed."""
    middles = run.route.ends - [0.5 * leg.curve.length for leg in run.route.legs]
    for middle, course in zip(middles, courses, strict=True):
        try:
            q = _followed(arm, course, q)[0][-1]
        except FFGymError:
            return run.moves[int(np.searchsorted(run.targets, middle * (1 - 1e-9)))]
    return run.moves[0]
