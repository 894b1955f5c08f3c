"""Deviation of a path that a controller runs from the plan that it was made for."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy

from ffgym.core.types import Array, IntArray
from ffgym.deployment.programs.points import distances_from_lines, tool_levers
from ffgym.robot import RigidArm

_STEP = 1e-4
"""Longest line [m] between positions; chosen: short beside the curves of paths."""
_MOST = 500_000
"""Most lines that are looked at; chosen: seconds of work."""


@dataclass(frozen=True, kw_only=True)
class PathDeviation:
    """Distance of a path from a plan, wherever they are in time."""

    distance: float
    """Largest distance of the tool [m]: of a set-point from the path, or of a point of the path from the plan."""
    t: float
    """Time in the plan [s] at which that is."""
    duration: float
    """Duration of the path [s]."""


def measure_deviation(arm: RigidArm, setpoints: Array, t: Array, path: Array, duration: float) -> PathDeviation:
    """Measure the distance between set-points (T, N) at times `t` (T,) and a path through joint positions (K, N).

    Between their positions both are lines in joint space.
    """
    levers = tool_levers(arm, setpoints)
    weights = np.maximum(np.linalg.norm(levers, axis=1).max(axis=0), 0.1)
    from_path, _ = _distances(setpoints, levers, path, weights)
    from_plan, nearest = _distances(path, tool_levers(arm, path), setpoints, weights)
    far, beside = int(np.argmax(from_path)), int(np.argmax(from_plan))
    if from_path[far] >= from_plan[beside]:
        return PathDeviation(distance=float(from_path[far]), t=float(t[far]), duration=duration)
    return PathDeviation(distance=float(from_plan[beside]), t=float(t[nearest[beside]]), duration=duration)


def _distances(points: Array, levers: Array, path: Array, weights: Array) -> tuple[Array, IntArray]:
    """Distances of points (T, N) from lines through a path (K, N) [m], shape (T,), and the index of the nearest in it.

    Each point is compared with the lines at all positions nearby, in joint space with each joint in units of what it
    moves the tool, `weights` (N,); laps of one path may lie between. `levers` (T, 3, N) are those at the points.
    """
    fine, source, longest = _refine(path, weights)
    tree = scipy.spatial.cKDTree(fine * weights)
    away, nearest = tree.query(points * weights)
    found: Any = tree.query_ball_point(points * weights, away + longest)
    near = [np.asarray(some, dtype=int) for some in found]
    which = np.repeat(np.arange(len(points)), [len(some) for some in near])
    distances = np.full(len(points), np.inf)
    for first in np.concatenate(near)[None] - np.array([[0], [1]]):
        start, end = fine[np.maximum(first, 0)], fine[np.clip(first + 1, 0, len(fine) - 1)]
        apart, _ = distances_from_lines(levers[which], points[which] - start, end - start)
        np.minimum.at(distances, which, apart)
    return distances, source[nearest]


def _refine(path: Array, weights: Array) -> tuple[Array, IntArray, float]:
    """Divide lines between joint positions (K, N) so that none is longer than _STEP, as far as there are not too many.

    Returns the positions (L, N), the index in the path from which each comes (L,), and the longest line.
    """
    lengths = np.linalg.norm(np.diff(path, axis=0) * weights, axis=1)
    step = max(_STEP, float(lengths.sum()) / _MOST)
    counts = np.maximum(np.ceil(lengths / step).astype(int), 1)
    which = np.repeat(np.arange(len(counts)), counts)
    share = np.concatenate([np.arange(count) / count for count in counts])
    inside = path[which] + share[:, None] * (path[which + 1] - path[which])
    return np.concatenate([inside, path[-1:]]), np.append(which, len(path) - 1), step
