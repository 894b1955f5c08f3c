"""Pictures of the page as numbers that a template draws: tool paths, learning curves, standings at a glance."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from ffgym.core.errors import check_shape
from ffgym.core.types import Array
from ffgym.leaderboard.comparison.standings import Standings
from ffgym.leaderboard.plants import THESIS_WORKCELL
from ffgym.leaderboard.results import Row
from ffgym.recordings.metrics import magnification, magnify, nearest_on_polylines
from ffgym.report.circles.paths_plot import MOST, unit_vectors
from ffgym.report.table import shorten
from ffgym.report.tool_path import scale_words

_POINTS = 150
"""Points drawn of one path at most, enough for a line without corners at this size."""
_REACH = 0.3
"""Share of half the path's width that its largest enlarged error may take; chosen: the path stays recognisable."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ToolTrace:
    """Path of the tool and of its reference seen along the normal of their plane, on one motion."""

    reference: ArrayLike
    """Points [mm], shape (R, 2), in the order of the path."""
    tool: ArrayLike
    """Points [mm], shape (T, 2); T may differ from R."""
    where: str = ""
    """Motion and machine, in words."""
    points: Array = field(init=False, repr=False)
    """Drawn points of the reference [mm], shape (R, 2)."""
    _near: Array = field(init=False, repr=False)
    _error: Array = field(init=False, repr=False)

    def __post_init__(self) -> None:
        reference = check_shape("reference", self.reference, (None, 2))
        tool = _thin(check_shape("tool", self.tool, (None, 2)))
        near = nearest_on_polylines(tool, np.broadcast_to(reference, (len(tool), *reference.shape)))
        for name, value in (("points", _thin(reference)), ("_near", near), ("_error", tool - near)):
            object.__setattr__(self, name, value)

    def enlarge(self, factor: float) -> Array:
        """Enlarge the distance of the tool from the nearest point of the reference [mm], shape (T, 2)."""
        return magnify(self._near, self._error, factor)

    @property
    def magnification(self) -> float:
        """Largest factor that leaves the path recognisable."""
        largest = float(np.linalg.norm(self._error, axis=1).max())
        room = _REACH * float(np.ptp(self.points, axis=0).max()) / 2
        return magnification(room, largest, MOST)


ToolTraces = Mapping[str, Mapping[float, ToolTrace]]
"""Traces by name of the row and TCP speed [mm/s]."""


@dataclass(frozen=True, kw_only=True)
class PictureLine:
    """A line of a picture, whose width does not grow with it."""

    points: str
    """Points in SVG, y downwards."""
    colour: str
    """Name of a colour in the template."""
    width: float
    dash: str = ""

    @classmethod
    def through(cls, points: ArrayLike, colour: str, width: float, dash: str = "") -> Self:
        """Make a line through points, shape (T, 2), y upwards."""
        places = " ".join(f"{number(x)},{number(-y)}" for x, y in np.asarray(points, dtype=float))
        return cls(points=places, colour=colour, width=width, dash=dash)


@dataclass(frozen=True, kw_only=True)
class Picture:
    """Path of the tool with its caption."""

    lines: tuple[PictureLine, ...]
    box: str
    """View box of SVG: corner and size."""
    caption: str


@dataclass(frozen=True, kw_only=True)
class LearningCurve:
    """Mean reward per step over steps of training."""

    steps: Array
    rewards: Array
    low: float
    """Lowest reward."""
    high: float
    """Upper end of the axis."""
    line: PictureLine
    """The curve in its frame of 348 x 154 pixels."""


def learning_curve(points: Sequence[tuple[float, float]]) -> LearningCurve | None:
    """Scale the curve of steps and rewards to its frame; return None for fewer than two points."""
    if len(points) < 2:
        return None
    steps, rewards = np.asarray(points, dtype=float).T
    low = float(rewards.min())
    high = max(float(rewards.max()), low + 1.0 * (np.ptp(rewards) == 0))
    x = 58 + 348 * (steps - steps[0]) / max(float(np.ptp(steps)), 1.0)
    y = 12 + 154 * (high - rewards) / (high - low)
    line = PictureLine.through(np.stack([x, -y], axis=1), "own", 1.8)
    return LearningCurve(steps=steps, rewards=rewards, low=low, high=high, line=line)


def number(value: float) -> str:
    """Format a number of a picture, with three digits behind the point at most."""
    digits = f"{value:.3f}".rstrip("0").rstrip(".")
    return "0" if digits == "-0" else digits


def compute_traces(rows: Sequence[Row]) -> dict[str, dict[float, ToolTrace]]:
    """Compute traces from the trails on the public workcell, of each row's first seed; rows may have none."""
    circle = unit_vectors(np.linspace(0, 2 * np.pi, 721))
    found: dict[str, dict[float, ToolTrace]] = {}
    for row in rows:
        known = [outcome for outcome in row.outcomes if outcome.plant == THESIS_WORKCELL and outcome.trails]
        for trail in min(known, key=lambda outcome: outcome.seed).trails if known else ():
            deviation = np.asarray(trail.deviation_um) * 1e-3
            outwards = unit_vectors(np.linspace(0, 2 * np.pi, len(deviation), endpoint=False))
            found.setdefault(row.name, {})[trail.speed_mm_s] = ToolTrace(
                reference=trail.radius_mm * circle,
                tool=(trail.radius_mm + deviation)[:, None] * outwards,
                where=f"{trail.position}, r = {trail.radius_mm:g} mm, {THESIS_WORKCELL}",
            )
    return found


def tool_pictures(paths: Mapping[float, ToolTrace], zero: Mapping[float, ToolTrace]) -> list[Picture]:
    """Draw one picture per speed, slowest first, with the path of the zero action equally enlarged, if any."""
    return [_picture(paths[speed], zero.get(speed), speed) for speed in sorted(paths)]


def _picture(path: ToolTrace, zero: ToolTrace | None, speed: float) -> Picture:
    """Draw reference, zero action and tool, all at one magnification."""
    factor = path.magnification if zero is None else zero.magnification
    lines = [PictureLine.through(path.points, "reference", 1, "4 3")]
    drawn = [path.points, path.enlarge(factor)]
    if zero is not None and zero is not path:
        drawn.append(zero.enlarge(factor))
        lines.append(PictureLine.through(drawn[-1], "zero", 1.2))
    lines.append(PictureLine.through(drawn[1], "own", 1.8))
    every = np.concatenate(drawn)
    low, span = every.min(axis=0), float(np.ptp(every, axis=0).max()) * 1.06
    corner = low - (span - np.ptp(every, axis=0)) / 2
    box = f"{number(corner[0])} {number(-corner[1] - span)} {number(span)} {number(span)}"
    return Picture(lines=tuple(lines), box=box, caption=f"{speed:g} mm/s, {scale_words(factor)}")


def _thin(points: Array) -> Array:
    return points[np.unique(np.linspace(0, len(points) - 1, min(_POINTS, len(points))).round().astype(int))]


_SPEEDS = {10.0: "#009E73", 20.0: "#56B4E9", 40.0: "#E69F00", 70.0: "#CC79A7", 100.0: "#D55E00"}
"""Colours by speed [mm/s]; those of the thesis as in other pages."""
_TICKS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0)
"""Shares of the error that may be marked."""


@dataclass(frozen=True, kw_only=True)
class Glance:
    """Share of the zero action's mean error that ranked rows leave at every speed, on a logarithmic axis."""

    colours: dict[float, str]
    """Colours by speed [mm/s]."""
    ticks: list[tuple[float, float]]
    """Marked shares, and their positions along the axis, 0 to 1."""
    rows: list[tuple[str, dict[float, float]]]
    """Rank and title of each row, and its positions by speed."""


def glance(standings: Standings) -> Glance | None:
    """Scale all standings to one axis; return None if no robot moved."""
    speeds = standings.grid.speeds_mm_s
    shares = [[1 - each.reduction for each in line.score.speeds] for line in standings.ranked]
    finite = [share for row in shares for share in row if np.isfinite(share) and share > 0]
    if not finite:
        return None
    low, high = min(*finite, 0.5) / 1.15, max(*finite, 1.0) * 1.15

    def place(share: float) -> float:
        return float(np.log(share / low) / np.log(high / low))

    titles = [f"{line.rank}  {shorten(line.row.title, 42)}" for line in standings.ranked]
    return Glance(
        colours={speed: _SPEEDS.get(speed, "#1c2430") for speed in speeds},
        ticks=[(tick, place(tick)) for tick in _TICKS if low <= tick <= high],
        rows=[
            (title, {v: place(x) for v, x in zip(speeds, row, strict=True) if np.isfinite(x) and x > 0})
            for title, row in zip(titles, shares, strict=True)
        ],
    )
