"""Moves of the joints, from rest to rest.

The path is a curve through joint positions, each in units of its joint's largest speed: its length is the time [s] that
the fastest joint takes at that speed.
"""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import scipy

from ffgym.core.errors import errors_at
from ffgym.core.types import Array
from ffgym.paths.curves import Curve, Line, spline_through
from ffgym.paths.limits import MARGIN, Bounds, MotionLimits, axis_bounds, stretches
from ffgym.paths.motions.rows import ReferencePiece, Step, add_step, rows_along
from ffgym.paths.moves import JointMove, MoveJoint, locate_error
from ffgym.paths.route import Leg, round_corners
from ffgym.paths.timing import time_law
from ffgym.recordings import PhaseKind
from ffgym.robot import RigidArm

_ZONE_POINTS = 64
"""Points on half a leg at which the distance of the tool from its target is examined."""


def check_range(arm: RigidArm, move: JointMove, target: Array) -> None:
    """Check that joint positions `target` can be a target of `move`."""
    kinematics = arm.robot.kinematics
    if target.shape != (arm.robot.n_joints,):
        raise locate_error(
            move, f"{len(target)} joint positions for the {arm.robot.n_joints} joints of {arm.robot.name!r}."
        )
    outside = np.flatnonzero(kinematics.beyond_limits(target))
    if outside.size:
        j = int(outside[0])
        raise locate_error(
            move,
            f"Joint {arm.robot.joints[j]} = {target[j]:.4g} {kinematics.units[j]} is out of range, must be within "
            f"{np.round(kinematics.range[j], 4).tolist()} {kinematics.units[j]}.",
        )


def joint_steps(arm: RigidArm, moves: Sequence[JointMove], targets: Sequence[Array], q: Array) -> list[Step]:
    """Curves from `q` (N,) through joint positions `targets`, (K, N) for each move; moves that go nowhere make none."""
    unit = arm.robot.kinematics.max_speed
    steps: list[Step] = []
    for move, through in zip(moves, targets, strict=True):
        for target in through:
            check_range(arm, move, target)
        points = np.vstack([q[None], through]) / unit
        points = points[1:] if np.all(points[0] == points[1]) else points
        leg = None
        if len(points) > 1 and isinstance(move, MoveJoint):
            leg = Leg(curve=Line(start=points[0], end=points[1]), speed=move.speed)
        elif len(points) > 1:
            with errors_at(move.where):
                leg = Leg(curve=spline_through(points), speed=None)
        add_step(steps, move, leg)
        q = through[-1]
    return steps


def run_joints(arm: RigidArm, steps: Sequence[Step], limits: MotionLimits) -> ReferencePiece:
    """Joint motion from rest to rest through the targets of `steps`, as fast as speeds and limits allow."""
    legs = [step.leg for step in steps]
    zones = [_zone(arm, before, after) for before, after in pairwise(steps)]
    route, targets = round_corners(legs, zones)
    grid = [leg.grid() for leg in route.legs]
    bounds = [_bounds(arm, leg, s, limits) for leg, s in zip(route.legs, grid, strict=True)]
    law = time_law(stretches(grid, bounds))
    unit = arm.robot.kinematics.max_speed

    def path(s: Array) -> tuple[Array, Array, Array]:
        position, first, second, _ = route.at(s).path
        return position * unit, first * unit, second * unit

    phases: list[tuple[str, PhaseKind]] = [(step.move.label, "motion") for step in steps]
    passed = [(step.move, float(target)) for step, target in zip(steps, targets, strict=True)]
    return rows_along(law, path, targets, phases, passed, arm.robot.servo.control_dt)


def _zone(arm: RigidArm, before: Step, after: Step) -> float:
    """Compute the length along both legs within the zone around the target, at most half of the shorter leg."""
    if arm.robot.tool is None:
        raise locate_error(
            before.move, f"A zone is a distance of the TCP, which {arm.robot.name!r} has not; stop there."
        )
    first, second = before.leg.curve, after.leg.curve
    half, radius = 0.5 * min(first.length, second.length), before.move.zone.radius
    return min(_within(arm, first, first.length, half, radius), _within(arm, second, 0.0, half, radius))


def _within(arm: RigidArm, curve: Curve, corner: float, longest: float, radius: float) -> float:
    """Length of a curve from one of its ends on which the TCP stays within `radius` [m] of that end."""
    unit = arm.robot.kinematics.max_speed

    def beyond(length: Array | float) -> Array:
        points = arm.tcp_position(curve.at(np.abs(corner - np.append(0.0, length)))[0] * unit)
        return np.linalg.norm(points[1:] - points[0], axis=1) - radius

    away = np.linspace(0.0, longest, _ZONE_POINTS + 1)
    outside = np.flatnonzero(beyond(away) > 0)
    if not outside.size:
        return longest
    inner, outer = away[outside[0] - 1], away[outside[0]]
    return float(scipy.optimize.brentq(lambda length: float(beyond(length)[0]), inner, outer))


def _bounds(arm: RigidArm, leg: Leg, s: Array, limits: MotionLimits) -> Bounds:
    """Bounds on the speed along a leg at lengths `s`, from the joints and from the programmed speed of the tool."""
    unit = arm.robot.kinematics.max_speed
    position, *slopes = (part * unit for part in leg.at(s).path)
    still = np.zeros(len(s))
    fastest = still + np.inf  # at which tool and orientation are not faster than programmed
    if leg.speed is not None and arm.robot.tool is not None:
        twist = np.einsum("tij,tj->ti", arm.jacobian(position), slopes[0])
        moved, turned = np.linalg.norm(twist[:, :3], axis=1), np.linalg.norm(twist[:, 3:], axis=1)
        tiny = np.finfo(np.float64).tiny
        with np.errstate(over="ignore"):  # a tool that does not turn, or not move, sets no bound
            fastest = MARGIN * np.minimum(
                leg.speed.tcp / np.maximum(moved, tiny), leg.speed.turn / np.maximum(turned, tiny)
            )
    shares = (1.0, 1.0) if leg.speed is None else (leg.speed.acceleration, leg.speed.jerk)
    cap = Bounds(
        speed=fastest,
        acceleration=still + limits.joint_rise * shares[0],
        jerk=still + limits.joint_rise_jerk * shares[1],
    )
    return axis_bounds(slopes, limits.of_joints(unit), cap)
