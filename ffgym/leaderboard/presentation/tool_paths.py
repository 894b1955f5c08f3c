"""The path of the tool with its error enlarged, as a picture inside a page."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import final

import numpy as np
from numpy.typing import ArrayLike

from ffgym.core.errors import check_shape
from ffgym.core.types import Array
from ffgym.leaderboard.plants import THESIS_WORKCELL
from ffgym.leaderboard.presentation.svg import COLOURS, number, polyline
from ffgym.leaderboard.results import Row, Trail
from ffgym.recordings.metrics import magnification, magnified, nearest_on_polylines
from ffgym.report.circles.paths_plot import MOST
from ffgym.report.tool_path import scale_words

_POINTS = 150
"""Points drawn of one path at most, enough for a line without corners at this size."""
_SIZE = 240
"""Width and height of a picture [px]."""
_REACH = 0.3
"""Share of half the path's width that its largest enlarged error may take; chosen: the path stays recognisable."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ToolPath:
    """Path of the tool and of its reference seen along the normal of their plane, on one motion."""

    reference: ArrayLike
    """Points [mm], shape (R, 2), in the order of the path."""
    tool: ArrayLike
    """Points [mm], shape (T, 2); T may differ from R."""
    where: str = ""
    """Which motion on which machine, in words."""
    _reference: Array = field(init=False, repr=False)
    _error: Array = field(init=False, repr=False)

    def __post_init__(self) -> None:
        reference = check_shape("reference", self.reference, (None, 2))
        tool = _thinned(check_shape("tool", self.tool, (None, 2)))
        near = nearest_on_polylines(tool, np.broadcast_to(reference, (len(tool), *reference.shape)))
        object.__setattr__(self, "_reference", _thinned(reference))
        object.__setattr__(self, "_error", np.stack([near, tool - near]))

    @property
    def points(self) -> Array:
        """The reference, as it is drawn [mm], shape (R, 2)."""
        return self._reference

    def enlarged(self, factor: float) -> Array:
        """Path of the tool with its distance from the nearest point of the reference enlarged [mm], shape (T, 2)."""
        near, error = self._error
        return magnified(near, error, factor)

    @property
    def magnification(self) -> float:
        """Largest factor that leaves the path recognisable."""
        largest = float(np.linalg.norm(self._error[1], axis=1).max())
        room = _REACH * float(np.ptp(self._reference, axis=0).max()) / 2
        return magnification(room, largest, MOST)


ToolPaths = Mapping[str, Mapping[float, ToolPath]]
"""By name of the row and TCP speed [mm/s]."""


@final
@dataclass(frozen=True, kw_only=True)
class Picture:
    """A picture and what stands below it."""

    svg: str
    """Its numbers are made here; no text of others is in it."""
    caption: str


def paths_of(rows: Sequence[Row], plant: str = THESIS_WORKCELL) -> dict[str, dict[float, ToolPath]]:
    """Paths from the trails of results on a plant, those of each row's first seed; rows without any are left out."""
    found = {row.name: _paths(row, plant) for row in rows}
    return {name: paths for name, paths in found.items() if paths}


def _paths(row: Row, plant: str) -> dict[float, ToolPath]:
    outcomes = sorted(
        (each for each in row.outcomes if each.plant == plant and each.trails), key=lambda each: each.seed
    )
    return {trail.speed_mm_s: _circle(trail, plant) for outcome in outcomes[:1] for trail in outcome.trails}


def _circle(trail: Trail, plant: str) -> ToolPath:
    deviation = np.asarray(trail.deviation_um) * 1e-3
    return ToolPath(
        reference=trail.radius_mm * _unit(np.linspace(0, 2 * np.pi, 721)),
        tool=(trail.radius_mm + deviation)[:, None] * _unit(np.linspace(0, 2 * np.pi, len(deviation), endpoint=False)),
        where=f"{trail.position}, r = {trail.radius_mm:g} mm, {plant}",
    )


def _unit(angle: Array) -> Array:
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)


def tool_pictures(paths: Mapping[float, ToolPath], zero: Mapping[float, ToolPath]) -> list[Picture]:
    """One picture per speed, slowest first; with the path of the zero action where there is one, equally enlarged."""
    return [_picture(paths[speed], zero.get(speed), speed) for speed in sorted(paths)]


def _picture(path: ToolPath, zero: ToolPath | None, speed: float) -> Picture:
    factor = path.magnification if zero is None else zero.magnification
    lines = [polyline(path.points, "#8a94a1", width=1, dash="4 3")]
    drawn = [path.points, path.enlarged(factor)]
    if zero is not None and zero is not path:
        drawn.append(zero.enlarged(factor))
        lines.append(polyline(drawn[-1], COLOURS["zero"], width=1.2))
    lines.append(polyline(drawn[1], COLOURS["own"], width=1.8))
    every = np.concatenate(drawn)
    low, span = every.min(axis=0), float(np.ptp(every, axis=0).max()) * 1.06
    corner = low - (span - np.ptp(every, axis=0)) / 2
    box = f"{number(corner[0])} {number(-corner[1] - span)} {number(span)} {number(span)}"
    words = scale_words(factor)
    svg = (
        f'<svg viewBox="{box}" width="{_SIZE}" height="{_SIZE}" role="img" aria-label="Path of the tool at '
        f'{speed:g} mm/s, {words}">{"".join(lines)}</svg>'
    )
    return Picture(svg=svg, caption=f"{speed:g} mm/s, {words}")


def _thinned(points: Array) -> Array:
    return points[np.unique(np.linspace(0, len(points) - 1, min(_POINTS, len(points))).round().astype(int))]
