"""The path of the tool on any motion, with the path error magnified."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ffgym.core.types import Array
from ffgym.paths.circles import plane_of
from ffgym.recordings.metrics import Contour
from ffgym.report._matplotlib import house_style, legend_above, new_figure
from ffgym.report.laws import LawStyle, law_styles
from ffgym.studies import MotionStudy

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SHARE = 0.08
"""Largest drawn deviation over the size of the path; chosen, so that the shape stays that of the path."""
_FLAT = 0.01
"""Extent over size of the path below which it is flat, or straight; chosen: a hundredth of a picture is a line."""
_POINTS = 6000
"""Points drawn of one path; a stretch of vibration keeps its shape up to there."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Sight:
    """A direction to look at a path from."""

    axes: Array
    """What points right and up in the picture, unit vectors in the world, shape (2, 3)."""
    labels: tuple[str, str]
    origin: Array
    """World point [m] at the picture's zero, shape (3,)."""

    @property
    def normal(self) -> Array:
        """Unit vector towards the viewer, shape (3,)."""
        return np.cross(*self.axes)

    def flat(self, points: Array) -> Array:
        """Points (T, 3) [m] in the picture [mm], shape (T, 2)."""
        moved = 1e3 * (points - self.origin)
        return np.stack([(moved * axis).sum(axis=1) for axis in self.axes], axis=1)


def sights_of(path: Array) -> list[Sight]:
    """How to look at a path (T, 3) [m]: along its normal if it is flat, else from above and from its longer side.

    An upright line is seen from two sides.
    """
    centred = path - path.mean(axis=0)
    directions = np.linalg.eigh(centred.T @ centred)[1]  # least spread first
    extent = np.ptp(centred @ directions, axis=0)
    flat = extent[0] <= _FLAT * extent[2] < extent[1]
    if not flat:
        x, y, z = np.ptp(path, axis=0)
        if max(x, y) <= _FLAT * z:
            return [_world_sight((0, 2)), _world_sight((1, 2))]
        return [_world_sight((0, 1)), _world_sight((0, 2) if x >= y else (1, 2))]
    normal = directions[:, 0]
    along = int(np.argmax(np.abs(normal)))
    if abs(normal[along]) > 1 - _FLAT**2:
        return [_world_sight(tuple(k for k in range(3) if k != along))]
    plane = plane_of(np.sign(normal[along]) * normal)
    labels = [f"along ({', '.join(f'{x:.2f}' for x in axis + 0.0)}) [mm]" for axis in (plane.first, plane.second)]
    return [Sight(axes=np.stack([plane.first, plane.second]), labels=(labels[0], labels[1]), origin=path[0])]


def magnification(contours: Mapping[str, Contour]) -> float:
    """Round factor, 1 or more, with which the largest deviation is drawn as at most SHARE of the path's size."""
    size = max(float(np.linalg.norm(np.ptp(contour.nearest, axis=0))) for contour in contours.values())
    return round_factor(size, max(float(contour.distance.max()) for contour in contours.values()))


def round_factor(size: float, largest: float) -> float:
    """Round factor, 1 or more, with which a deviation is drawn as at most SHARE of `size`, in the same unit."""
    if largest == 0:
        return 1.0
    power = 10.0 ** np.floor(np.log10(SHARE * size / largest))
    return float(max(1.0, *(step * power for step in (1, 2, 5) if step * power * largest <= SHARE * size)))


def tool_path_figure(study: MotionStudy, motion: str) -> "Figure":
    """Path of the tool with every law, nearest point of the path + factor x (TCP - nearest point), in 1 or 2 views."""
    contours = _contours(study, motion)
    factor, styles = magnification(contours), law_styles(study.agents)
    reference = study.recordings[study.agents[0], motion].vector("tcp_reference.position")
    sights = sights_of(reference)
    with house_style():
        figure = new_figure(7.0 if len(sights) == 1 else 11.0, 5.6)
        for axes, sight in zip(figure.subplots(1, len(sights), squeeze=False)[0], sights, strict=True):
            _draw(axes, sight, reference, contours, factor, styles)
        legend_above(figure, *figure.axes[0].get_legend_handles_labels())
    return figure


def tool_path_caption(study: MotionStudy, motion: str) -> str:
    """What the figure shows, with its magnification and the largest deviation of each law."""
    contours = _contours(study, motion)
    factor, styles = magnification(contours), law_styles(study.agents)
    worst = ", ".join(f"{styles[law].label} {1e3 * contour.distance.max():.3f} mm" for law, contour in contours.items())
    drawn = "drawn to scale" if factor == 1 else f"drawn {factor:g} times as large"
    sights = sights_of(study.recordings[study.agents[0], motion].vector("tcp_reference.position"))
    hidden = max(float(np.abs(contour.error @ sights[0].normal).max()) for contour in contours.values())
    looked = f"Seen along its normal, up to {1e3 * hidden:.3f} mm are out of its plane. " if len(sights) == 1 else ""
    return (
        f"{looked}Dashed: reference. Deviations from it are {drawn}; where the tool is late on the right path there is "
        f"none. The offset at the start is removed. Dots: largest deviation in space ({worst})."
    )


def _contours(study: MotionStudy, motion: str) -> dict[str, Contour]:
    return {law: Contour.of(study.recordings[law, motion]) for law in study.agents}


def _draw(
    axes: "Axes",
    sight: Sight,
    reference: Array,
    contours: Mapping[str, Contour],
    factor: float,
    styles: Mapping[str, LawStyle],
) -> None:
    widths = np.linspace(2.4, 1.0, len(contours)) if len(contours) > 1 else [1.3]  # what lies below shows beside
    for width, (law, contour) in zip(widths, contours.items(), strict=True):
        drawn = sight.flat(contour.nearest + factor * contour.error)
        every = max(1, len(drawn) // _POINTS)
        style = styles[law]
        axes.plot(*drawn[::every].T, color=style.colour, linestyle=style.line, linewidth=width, label=style.label)
        worst = int(np.argmax(contour.distance))
        axes.plot(*drawn[worst], "o", color=style.colour, markersize=4.5)
    path = sight.flat(reference)
    axes.plot(*path[:: max(1, len(path) // _POINTS)].T, "k", linewidth=0.7, linestyle=(0, (5, 3)), label="reference")
    axes.set(xlabel=sight.labels[0], ylabel=sight.labels[1])
    axes.set_title("true scale" if factor == 1 else f"error × {factor:g}")
    axes.set_aspect("equal", adjustable="datalim")


def _world_sight(pair: tuple[int, ...]) -> Sight:
    first, second = pair
    labels = (f"{'xyz'[first]} [mm]", f"{'xyz'[second]} [mm]")
    return Sight(axes=np.eye(3)[[first, second]], labels=labels, origin=np.zeros(3))
