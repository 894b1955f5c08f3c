"""Picture of the path of a tool with its error magnified, on any motion and beside any path."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from ffgym.core.types import Array
from ffgym.paths.circles import plane_of
from ffgym.recordings.metrics import magnification, magnify
from ffgym.report.figure import panels

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SHARE = 0.08
"""Largest drawn deviation over the size of the path; chosen, so that the shape stays that of the path."""
_FLAT = 0.01
"""Extent over size of the path below which it is flat, or straight; chosen: a hundredth of a picture is a line."""
_POINTS = 6000
"""Points drawn of one path; a stretch of vibration keeps its shape up to there."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ToolPath:
    """A path of the tool beside the one that it is compared with."""

    label: str
    nearest: Array
    """Nearest points of the other path [m], shape (T, 3)."""
    error: Array
    """Tool - nearest point [m], shape (T, 3)."""
    look: Mapping[str, Any] = field(default_factory=dict)
    """Options of its line in matplotlib."""

    @property
    def distance(self) -> Array:
        """Length of the error [m], shape (T,)."""
        return np.asarray(np.linalg.norm(self.error, axis=1))


@dataclass(frozen=True, kw_only=True, eq=False)
class Sight:
    """View of a path from one direction."""

    axes: Array
    """Unit vectors in the world that point right and up in the picture, shape (2, 3)."""
    labels: tuple[str, str]
    origin: Array
    """World point [m] at the picture's zero, shape (3,)."""

    @property
    def normal(self) -> Array:
        """Unit vector towards the viewer, shape (3,)."""
        return np.cross(*self.axes)

    def flat(self, points: Array) -> Array:
        """Project points (T, 3) [m] into the picture [mm], shape (T, 2)."""
        moved = 1e3 * (points - self.origin)
        return np.stack([(moved * axis).sum(axis=1) for axis in self.axes], axis=1)


def choose_sights(path: Array) -> list[Sight]:
    """Choose the views of a path (T, 3) [m]: along its normal if it is flat, else from above and from its longer side.

    An upright line is seen from two sides.
    """
    centred = path - path.mean(axis=0)
    directions = np.linalg.eigh(centred.T @ centred)[1]  # least spread first
    extent = np.ptp(centred @ directions, axis=0)
    flat = extent[0] <= _FLAT * extent[2] < extent[1]
    # a path in space, or an upright line
    if not flat:
        x, y, z = np.ptp(path, axis=0)
        if max(x, y) <= _FLAT * z:
            return [_world_sight((0, 2)), _world_sight((1, 2))]
        return [_world_sight((0, 1)), _world_sight((0, 2) if x >= y else (1, 2))]
    # a flat path, in a plane of the world or in its own
    normal = directions[:, 0]
    along = int(np.argmax(np.abs(normal)))
    if abs(normal[along]) > 1 - _FLAT**2:
        return [_world_sight(tuple(k for k in range(3) if k != along))]
    plane = plane_of(np.sign(normal[along]) * normal)
    labels = [f"along ({', '.join(f'{x:.2f}' for x in axis + 0.0)}) [mm]" for axis in (plane.first, plane.second)]
    return [Sight(axes=np.stack([plane.first, plane.second]), labels=(labels[0], labels[1]), origin=path[0])]


def choose_scale(paths: Sequence[ToolPath], beside: Array) -> float:
    """Choose a round factor, 1 or more, that draws the largest error as at most SHARE of the size of `beside`."""
    size = float(np.linalg.norm(np.ptp(beside, axis=0)))
    return magnification(SHARE * size, max(float(path.distance.max()) for path in paths))


def tool_path_figure(
    paths: Sequence[ToolPath],
    beside: Array,
    look: Mapping[str, Any],
    factor: float,
    *,
    what: str = "error",
    sizes: Sequence[tuple[float, float]] = ((7.0, 5.6), (11.0, 5.6)),
) -> "Figure":
    """Draw paths with their errors enlarged beside the path `beside`, in one or two views.

    Args:
        paths: paths of the tool; a dot marks the largest error of each.
        beside: the path that they are compared with [m], shape (R, 3).
        look: options of its line in matplotlib, with its label.
        factor: factor on the error.
        what: name of the enlarged quantity, for the title.
        sizes: size of the figure with one and with two views [inch].
    """
    sights = choose_sights(beside)
    with panels(1, len(sights), size=sizes[len(sights) - 1]) as (figure, grid):
        for axes, sight in zip(grid[0], sights, strict=True):
            for path in paths:
                drawn = sight.flat(magnify(path.nearest, path.error, factor))
                axes.plot(*_thin(drawn).T, label=path.label, **path.look)
                worst = int(np.argmax(path.distance))
                axes.plot(*drawn[worst], "o", color=path.look.get("color"), markersize=4.5)
            axes.plot(*_thin(sight.flat(beside)).T, **look)
            axes.set(xlabel=sight.labels[0], ylabel=sight.labels[1], title=scale_words(factor, what))
            axes.set_aspect("equal", adjustable="datalim")
    return figure


def scale_words(factor: float, what: str = "error") -> str:
    """Describe the enlargement of an error, for titles."""
    return "true scale" if factor == 1 else f"{what} × {factor:g}"


def _thin(points: Array) -> Array:
    return points[:: max(1, len(points) // _POINTS)]


def _world_sight(pair: tuple[int, ...]) -> Sight:
    first, second = pair
    labels = (f"{'xyz'[first]} [mm]", f"{'xyz'[second]} [mm]")
    return Sight(axes=np.eye(3)[[first, second]], labels=labels, origin=np.zeros(3))
