"""Moves of the tool in space, from rest to rest, as joint motion."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ffgym.errors import FFGymError
from ffgym.motions.rows import Rows, phases_at, sample_times
from ffgym.paths.bounds import Bounds, axis_bounds, slope_of, tool_bounds
from ffgym.paths.limits import MotionLimits
from ffgym.paths.moves import Move, located
from ffgym.paths.pacing import stretches
from ffgym.paths.route import Course, Route, chained
from ffgym.paths.timing import time_law
from ffgym.recordings import PhaseKind
from ffgym.robot import RigidArm, solve_path
from ffgym.robot.inverse_kinematics import joint_rates
from ffgym.types import Array


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
    grid = [leg.grid() for leg in run.route.legs]
    law = time_law(stretches(grid, _bounds(arm, run, grid, q, limits)))
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


def _bounds(arm: RigidArm, run: ToolRun, grid: list[Array], q: Array, limits: MotionLimits) -> list[Bounds]:
    """Bounds on path speed at the grid of each leg, from the tool and from the joints."""
    courses = [leg.at(s) for leg, s in zip(run.route.legs, grid, strict=True)]
    try:
        _, first, second = _followed(arm, chained(courses), q)
    except FFGymError as error:
        raise located(_blamed(arm, run, courses, q), str(error)) from error
    axes = limits.of_joints(arm.robot.kinematics.max_speed)
    cuts = np.cumsum([len(s) for s in grid])[:-1]
    slopes = zip(np.split(first, cuts), np.split(second, cuts), strict=True)
    return [
        axis_bounds((d1, d2, slope_of(d2, s)), axes, tool_bounds(leg.speed, s, course, limits))
        for leg, s, course, (d1, d2) in zip(run.route.legs, grid, courses, slopes, strict=True)
    ]


def _blamed(arm: RigidArm, run: ToolRun, courses: Sequence[Course], q: Array) -> Move:
    """The move whose leg is the first that cannot be followed."""
    middles = run.route.ends - [0.5 * leg.curve.length for leg in run.route.legs]
    for middle, course in zip(middles, courses, strict=True):
        try:
            q = _followed(arm, course, q)[0][-1]
        except FFGymError:
            return run.moves[int(np.searchsorted(run.targets, middle * (1 - 1e-9)))]
    return run.moves[0]
