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

RESOLVED = 0.1
"""Largest change of joint speeds per path speed from one point at which a leg is examined to the next, as a share of the
largest on the leg; chosen: what lies between is then missed by the square of it, which `bounds.MARGIN` covers."""
_REFINEMENTS = 6
"""How often the grid of a leg may be halved; near a singularity, which is refused, more would be needed."""


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


def _bounds(arm: RigidArm, run: ToolRun, q: Array, limits: MotionLimits) -> tuple[list[Array], list[Bounds]]:
    """Arc lengths at which each leg was examined, and bounds on path speed there, from the tool and from the joints."""
    legs, axes = run.route.legs, limits.of_joints(arm.robot.kinematics.max_speed)
    grid = [leg.grid() for leg in legs]
    for _ in range(_REFINEMENTS):
        slopes = _joint_slopes(arm, run, grid, q)
        coarse = [_changes(first / axes.speed) > RESOLVED for first, _ in slopes]
        if not any(coarse):
            break
        grid = [_halved(s) if c else s for s, c in zip(grid, coarse, strict=True)]
    else:
        slopes = _joint_slopes(arm, run, grid, q)
    bounds = [
        axis_bounds((first, second, slope_of(second, s)), axes, tool_bounds(leg.speed, s, leg.at(s), limits))
        for leg, s, (first, second) in zip(legs, grid, slopes, strict=True)
    ]
    return grid, bounds


def _joint_slopes(arm: RigidArm, run: ToolRun, grid: Sequence[Array], q: Array) -> list[tuple[Array, Array]]:
    """First two derivatives of the joint positions by path length at the grid of each leg, (K, N) each."""
    courses = [leg.at(s) for leg, s in zip(run.route.legs, grid, strict=True)]
    try:
        _, first, second = _followed(arm, chained(courses), q)
    except FFGymError as error:
        raise located(_blamed(arm, run, courses, q), str(error)) from error
    cuts = np.cumsum([len(s) for s in grid])[:-1]
    return list(zip(np.split(first, cuts), np.split(second, cuts), strict=True))


def _changes(slope: Array) -> float:
    """Largest change of a slope (K, N) from one point of the grid to the next, as a share of the largest slope."""
    return float(np.abs(np.diff(slope, axis=0)).max() / np.abs(slope).max())


def _halved(s: Array) -> Array:
    """Grid with twice as many intervals."""
    return np.linspace(s[0], s[-1], 2 * len(s) - 1)


def _blamed(arm: RigidArm, run: ToolRun, courses: Sequence[Course], q: Array) -> Move:
    """The move whose leg is the first that cannot be followed."""
    middles = run.route.ends - [0.5 * leg.curve.length for leg in run.route.legs]
    for middle, course in zip(middles, courses, strict=True):
        try:
            q = _followed(arm, course, q)[0][-1]
        except FFGymError:
            return run.moves[int(np.searchsorted(run.targets, middle * (1 - 1e-9)))]
    return run.moves[0]
