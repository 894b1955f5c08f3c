"""The circle that a stretch of reference points lies on."""

from dataclasses import dataclass

import numpy as np

from ffgym.core.errors import FFGymError, check_shape
from ffgym.core.types import Array

_ROUNDNESS = 1e-3
"""Largest deviation of a reference from a circle, in units of its radius, that still counts as one."""

_SMALLEST = 1e-9
"""Smallest radius of a circle [m]; below it points are one point."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Circle:
    """A circle in space."""

    centre: Array
    """[m], shape (3,)."""
    normal: Array
    """Unit normal of its plane, shape (3,)."""
    radius: float
    """[m]."""


def fit_circle(points: Array) -> Circle:
    """Least-squares circle through `points` (T, 3) [m], T >= 4.

    Raises:
        FFGymError: if the points do not lie on a circle.
    """
    points = check_shape("circle points", points, (None, 3))
    if len(points) < 4:
        raise FFGymError(f"A circle needs at least 4 points, got {len(points)}; record faster than the circle runs.")
    middle = points.mean(axis=0)
    normal = _normal(points - middle)
    first, second = _basis(normal)
    flat = np.stack([(points - middle) @ first, (points - middle) @ second], axis=1)
    system = np.column_stack([2 * flat, np.ones(len(flat))])
    (x, y, rest), *_ = np.linalg.lstsq(system, (flat**2).sum(axis=1), rcond=None)
    radius = float(np.sqrt(rest + x * x + y * y))
    centre = middle + x * first + y * second
    distance = np.linalg.norm(points - centre, axis=1)
    worst = float(np.abs(distance - radius).max())
    if not (worst <= _ROUNDNESS * radius and radius > _SMALLEST):
        raise FFGymError(
            f"The reference is no circle: it deviates by {worst:.3g} m from the best one, of radius {radius:.3g} m."
        )
    return Circle(centre=centre, normal=normal, radius=radius)


def _normal(centred: Array) -> Array:
    """Direction of least spread."""
    return np.linalg.eigh(centred.T @ centred)[1][:, 0]


def _basis(normal: Array) -> tuple[Array, Array]:
    guide = np.eye(3)[int(np.argmin(np.abs(normal)))]
    first = np.cross(normal, guide)
    first /= np.linalg.norm(first)
    return first, np.cross(normal, first)
