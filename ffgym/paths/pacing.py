"""How fast a route may be run at each of its points, as stretches for the time law."""

from collections.abc import Sequence

import numpy as np

from ffgym.core.types import Array
from ffgym.paths.bounds import Bounds
from ffgym.paths.timing import Stretch

VARIATION = 1.5
"""Ratio of the highest to the lowest speed bound beyond which a leg is halved; chosen: a third of the speed lost at
most, against time lost where stretches meet without acceleration."""
FEWEST = 4
"""Intervals in a stretch at least."""
SIMILAR = 2.0
"""Ratio of accelerations and jerks up to which stretches of one speed are run as one; chosen as VARIATION."""


def stretches(grid: Sequence[Array], bounds: Sequence[Bounds]) -> list[Stretch]:
    """Stretches that respect the bounds at every point of the grid.

    Args:
        grid: arc lengths at which each leg was examined, shape (K,) each.
        bounds: of each leg, at these points.
    """
    parts = [part for s, bound in zip(grid, bounds, strict=True) for part in _halved(s, bound, 0, len(s) - 1)]
    groups = [parts[:1]]
    for part in parts[1:]:
        if _alike([*groups[-1], part]):
            groups[-1].append(part)
        else:
            groups.append([part])
    return [_joined(group) for group in groups]


def _halved(s: Array, bound: Bounds, first: int, last: int) -> list[Stretch]:
    """Stretches between two points of the grid, halved until the speed bound varies little within each."""
    rows = slice(first, last + 1)
    speed = bound.speed[rows]
    middle = (first + last) // 2
    if speed.max() > VARIATION * speed.min() and middle - first >= FEWEST:
        return _halved(s, bound, first, middle) + _halved(s, bound, middle, last)
    whole = Stretch(
        length=float(s[last] - s[first]),
        speed=float(speed.min()),
        acceleration=float(bound.acceleration[rows].min()),
        jerk=float(bound.jerk[rows].min()),
    )
    return [whole]


def _alike(group: Sequence[Stretch]) -> bool:
    """Whether stretches have one speed, and accelerations and jerks that are similar."""
    a, j = [part.acceleration for part in group], [part.jerk for part in group]
    one_speed = len({part.speed for part in group}) == 1
    return one_speed and max(a) <= SIMILAR * min(a) and max(j) <= SIMILAR * min(j)


def _joined(group: Sequence[Stretch]) -> Stretch:
    return Stretch(
        length=float(np.sum([part.length for part in group])),
        speed=group[0].speed,
        acceleration=min(part.acceleration for part in group),
        jerk=min(part.jerk for part in group),
    )
