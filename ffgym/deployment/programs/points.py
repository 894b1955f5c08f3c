"""Points of a path: as few of the set-points of a plan as a controller needs to follow it."""

from dataclasses import dataclass

import numpy as np

from ffgym.core.errors import FFGymError, check_number, check_shape
from ffgym.core.types import Array, BoolArray
from ffgym.deployment.plan import SetpointPlan, numbers_per_unit
from ffgym.robot import RigidArm

TOLERANCE = 1e-5
"""Default distance [m] that the tool may have from the plan; chosen: a tenth of what robots repeat."""
_SHARE = 0.4
"""Share of the tolerance for lines between points; the rest is for corners and rounding."""
_TIMING = 0.01
"""Time [s] by which a line at constant speed may be ahead of the plan, or behind; chosen: a few servo steps."""
_LONGEST = 0.5
"""Longest time [s] between two points; chosen: a controller that is stopped goes on without a long wait."""
_SHORTEST_REST = 0.05
"""Shortest rest [s] that is written as a wait."""
ZONE = 3e-4
"""Radius of the corners that programs round [m], which reach halfway to their neighbours at most: ABB's z0."""
_SLOW = 5e-3
"""Speed of the tool [m/s] below which a sharp corner of the program is a stop: what robots gain in a set-point."""
_STILL = 1e-7
"""Speed of the tool [m/s] below which it rests."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PathPoints:
    """Points between which a controller moves all joints evenly."""

    name: str
    robot: str
    joints: tuple[str, ...]
    units: tuple[str, ...]
    """Unit of each joint position, rad or m."""
    t: Array
    """Times at which the plan is there [s], shape (K,)."""
    q: Array
    """Joint positions, link side [rad or m], as they are written, shape (K, N)."""
    rests: BoolArray
    """True for a point from which the robot rests until the time of the next, shape (K,)."""
    stops: BoolArray
    """True for a point at which the robot has to stop, at rests and sharp corners of the program, shape (K,)."""
    lengths: Array
    """Distance of the tool from the point before [m], shape (K,); 0 for the first."""
    turns: Array
    """Angle of the tool from the point before [rad], shape (K,)."""

    @property
    def speeds(self) -> Array:
        """Speed of the tool to each point [m/s], shape (K,); 0 for the first."""
        return self.lengths / np.diff(self.t, prepend=self.t[0] - 1.0)

    @property
    def turn_speeds(self) -> Array:
        """Turning speed of the tool to each point [rad/s], shape (K,); 0 for the first."""
        return self.turns / np.diff(self.t, prepend=self.t[0] - 1.0)


def round_numbers(q: Array, units: tuple[str, ...], digits: int) -> Array:
    """Round joint positions (K, N) as programs have them: degrees and millimetres, 32 bits, so many digits."""
    scale = numbers_per_unit(units)
    return np.asarray(np.round(q * scale, digits).astype(np.float32), dtype=np.float64) / scale


def tool_levers(arm: RigidArm, q: Array) -> Array:
    """Motion of the tool per motion of each joint at joint positions (T, N), shape (T, 3, N) [m/rad or 1].

    Raises:
        FFGymError: if the robot has no tool.
    """
    if arm.robot.tool is None:
        raise FFGymError(
            f"Robot {arm.robot.name!r} has no tool, so deviations cannot be told in mm; add flange.rotation and "
            "tool.tcp to its description."
        )
    return np.asarray(arm.jacobian(q)[:, :3], dtype=np.float64)


def count_digits(levers: Array, units: tuple[str, ...], tolerance: float) -> int:
    """Count digits behind the point whose rounding moves the tool by a tenth of `tolerance` [m] at most."""
    reach = np.abs(levers).max(axis=(0, 1)) / numbers_per_unit(units)
    for digits in range(2, 8):
        if 0.5 * 10.0**-digits * float(reach.sum()) <= 0.1 * tolerance:
            return digits
    raise FFGymError(f"A tolerance of {1e3 * tolerance:g} mm is finer than numbers of 32 bits; allow more.")


def choose_points(
    plan: SetpointPlan, arm: RigidArm, *, tolerance: float = TOLERANCE, period: float | None = None
) -> PathPoints:
    """Choose points of a plan such that lines in joint space between them stay near it.

    Args:
        plan: set-points with their correction.
        arm: the robot; its tool tells what a deviation of a joint is worth.
        tolerance: largest distance of the tool from the plan [m], of which lines use 40 %.
        period: time that points are apart at least [s], except around rests; None is the time between set-points, which
            corrections need where a joint turns back.

    Raises:
        FFGymError: if the plan is of another robot, the robot has no tool, or lines over the period leave the plan.
    """
    check_number("tolerance", tolerance, unit="m", low=1e-7, high=1e-3)
    spacing = plan.dt if period is None else check_number("period", period, unit="s", low=plan.dt, high=_LONGEST)
    q = check_shape("set-points of the plan", plan.setpoints, (None, arm.robot.n_joints))
    levers = tool_levers(arm, q)
    away = _SHARE * tolerance
    resting = _resting(plan, q, levers, away)
    chosen, rests = [0], []
    least = max(1, round(spacing / plan.dt))
    i = 0
    while i < len(q) - 1:
        end = _end_of_stretch(resting, i)
        rests.append(bool(resting[i]))
        i = end if resting[i] else _farthest(q, levers, i, end, least, plan.dt, away)
        chosen.append(i)
    rests.append(False)
    rounded = round_numbers(q[chosen], plan.units, count_digits(levers, plan.units, tolerance))
    position, rotation = arm.tcp_pose(rounded)
    steps = np.linalg.norm(np.diff(position, axis=0, prepend=position[:1]), axis=1)
    sharp = _corners(position) > away
    slow = _tool_speeds(plan, levers)[chosen] < _SLOW
    ends = np.isin(np.arange(len(chosen)), [0, len(chosen) - 1])
    traces = np.einsum("kij,kij->k", rotation, np.concatenate([rotation[:1], rotation[:-1]]))
    return PathPoints(
        name=plan.name,
        robot=plan.robot,
        joints=plan.joints,
        units=plan.units,
        t=plan.t[chosen],
        q=rounded,
        rests=np.array(rests),
        stops=ends | np.array(rests) | (sharp & slow),
        lengths=steps,
        turns=np.arccos(np.clip((traces - 1) / 2, -1.0, 1.0)),
    )


def _tool_speeds(plan: SetpointPlan, levers: Array) -> Array:
    """Compute the speed of the tool after each sample of the program [m/s], shape (T,)."""
    step = np.diff(plan.program, axis=0, append=plan.program[-1:])
    return np.asarray(np.abs(np.einsum("tij,tj->ti", levers, step)).max(axis=1) / plan.dt)


def _corners(position: Array) -> Array:
    """Compute how far a controller passes by each point (K, 3) that it rounds [m], shape (K,)."""
    ways = np.diff(position, axis=0)
    lengths = np.linalg.norm(ways, axis=1)
    passed = np.zeros(len(position))
    cosine = np.einsum("ki,ki->k", ways[:-1], ways[1:]) / np.maximum(lengths[:-1] * lengths[1:], 1e-18)
    radius = np.minimum(np.minimum(lengths[:-1], lengths[1:]) / 2, ZONE)
    # a parabola that begins a radius before the corner passes it at half the sagitta
    passed[1:-1] = radius * np.sqrt((1 - np.clip(cosine, -1.0, 1.0)) / 2) / 2
    return passed


def _resting(plan: SetpointPlan, q: Array, levers: Array, tolerance: float) -> BoolArray:
    """Tell for each step, shape (T,), if the robot rests in it.

    In a rest of the program the correction goes on for a while. It counts as motion until what is left of it moves the
    tool by `tolerance` [m] at most.
    """
    step = np.diff(plan.program, axis=0, append=plan.program[-1:])
    still = (_tool_speeds(plan, levers) < _STILL) & (np.abs(step).max(axis=1) < _STILL * plan.dt)
    resting = np.zeros(len(q), dtype=bool)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], still, [False]]).astype(int)))
    for start, end in zip(edges[::2], edges[1::2], strict=True):
        last = min(int(end), len(q) - 1)
        away = np.linalg.norm(np.einsum("tij,tj->ti", levers[start : last + 1], q[start : last + 1] - q[last]), axis=1)
        beyond = np.flatnonzero(away > 0.5 * tolerance)
        first = int(start) + (int(beyond[-1]) + 1 if beyond.size else 0)
        resting[first:end] = (last - first) * plan.dt >= _SHORTEST_REST
    return resting


def _end_of_stretch(resting: BoolArray, i: int) -> int:
    """Index of the sample at which the motion or rest that sample `i` is in ends."""
    other = np.flatnonzero(resting[i:] != resting[i])
    return int(i + other[0]) if other.size else len(resting) - 1


def _farthest(q: Array, levers: Array, i: int, end: int, least: int, dt: float, tolerance: float) -> int:
    """Farthest sample up to `end` that a line from sample `i` may lead to."""
    most = min(end, i + max(least, round(_LONGEST / dt)))
    best = min(i + least, end)
    if best - i > 1 and line_deviation(q, levers, i, best)[0] > tolerance:
        raise FFGymError(
            f"Lines over {1e3 * (best - i) * dt:g} ms leave the plan at {i * dt:.3f} s by "
            f"{1e3 * line_deviation(q, levers, i, best)[0]:.4f} mm, may leave it by {1e3 * tolerance:.4f} mm (40 % of "
            "the tolerance). Allow more, or a shorter period."
        )
    step = best - i
    while step >= 1:
        there = min(best + step, most)
        away, late = line_deviation(q, levers, i, there)
        if there > best and away <= tolerance and late * dt <= _TIMING:
            best, step = there, 2 * step
        else:
            step //= 2
        if best == most:
            break
    return best


def line_deviation(q: Array, levers: Array, i: int, j: int) -> tuple[float, float]:
    """Largest distance of the tool [m], and of the time [samples], between set-points and a line from `i` to `j`."""
    if j - i < 2:
        return 0.0, 0.0
    apart, share = distances_from_lines(levers[i + 1 : j], q[i + 1 : j] - q[i], q[j] - q[i])
    late = np.abs(share * (j - i) - np.arange(1, j - i))
    return float(apart.max()), float(late.max())


def distances_from_lines(levers: Array, points: Array, lines: Array) -> tuple[Array, Array]:
    """Compute how far the tool at points is from lines of joint space, each of which begins at 0.

    Args:
        levers: motion of the tool per motion of each joint, shape (T, 3, N).
        points: joint positions from the begin of their lines, shape (T, N).
        lines: ends of the lines from their begin, shape (T, N) or (N,).

    Returns:
        Distances [m], shape (T,), and the shares of the lines at which they are nearest, within [0, 1], shape (T,).
    """
    line = np.einsum("tij,tj->ti", levers, np.broadcast_to(lines, points.shape))
    there = np.einsum("tij,tj->ti", levers, points)
    length = np.maximum(np.einsum("ti,ti->t", line, line), np.finfo(np.float64).tiny)
    share = np.clip(np.einsum("ti,ti->t", line, there) / length, 0.0, 1.0)
    return np.linalg.norm(there - share[:, None] * line, axis=1), share
