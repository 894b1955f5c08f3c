"""The path of the tool on the circles, with the path error magnified: thesis Figures 4.6a to 4.12a."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array, BoolArray
from ffgym.paths.circles import Plane, plane_of
from ffgym.recordings import Phase, Recording
from ffgym.recordings.metrics import Circle, circle_deviation, fit_circle, magnification, magnified, standstill_offset
from ffgym.report.figure import panels
from ffgym.report.laws import LawStyle, law_styles
from ffgym.report.tool_path import scale_words
from ffgym.studies import CircleStudy

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST = 100.0
"""Largest factor that a path error is drawn with."""
_POINTS = 600
"""Points drawn on one circle, enough for a line without corners."""


@dataclass(frozen=True, kw_only=True, eq=False)
class FlatCircle:
    """One circle of a recording seen along its normal; T samples."""

    centre: Array
    """Relative to the centre of the first circle [mm], shape (2,)."""
    radius: float
    """[mm]."""
    angle: Array
    """Where the tool is [rad], shape (T,)."""
    outward: Array
    """Deviation in the plane, offset at standstill removed [mm], shape (T,)."""

    def path(self, magnification: float) -> Array:
        """Path of the tool [mm] with its deviation enlarged, shape (T, 2)."""
        outwards = unit_vectors(self.angle)
        return magnified(self.centre + self.radius * outwards, self.outward[:, None] * outwards, magnification)

    def reference(self) -> Array:
        """The circle [mm], shape (200, 2)."""
        return self.centre + self.radius * unit_vectors(np.linspace(0, 2 * np.pi, 200))


def flat_circles(recording: Recording) -> list[FlatCircle]:
    """Every circle of a recording, without lead-in and lead-out.

    Raises:
        FFGymError: if the recording has no circle or no standstill before the first one.
    """
    phases = recording.phases_of("circle")
    if not phases:
        raise FFGymError(f"Recording {recording.header.segment!r} has no phase of kind 'circle' to draw.")
    tcp = recording.vector("tcp.position") - standstill_offset(recording)
    reference = recording.vector("tcp_reference.position")
    stretches = [_rows(recording, phase) for phase in phases]
    fits = [fit_circle(reference[rows]) for rows in stretches]
    plane = _plane(fits[0])
    return [_flat(tcp[rows], fit, fits[0].centre, plane) for rows, fit in zip(stretches, fits, strict=True)]


def magnification_of(study: CircleStudy, speed: float) -> float:
    """Largest factor at `speed` [m/s] with which no circle reaches its neighbours or its own centre."""
    recordings = [recording for (_, _, v), recording in study.recordings.items() if v == speed]
    circles = [circle for recording in recordings for circle in flat_circles(recording)]
    radii = sorted({round(circle.radius, 2) for circle in circles})
    gap = float(np.diff([0.0, *radii]).max() if len(radii) < 3 else np.median(np.diff(radii)))
    return min(_largest_factor(circle, gap) for circle in circles)


def paths_figure(
    study: CircleStudy, *, positions: Sequence[str] | None = None, speeds: Sequence[float] | None = None
) -> "Figure":
    """Paths of every law: one row per speed, one column per position.

    Args:
        study: the circle test.
        positions: names; None takes all of the study.
        speeds: TCP speeds [m/s]; None takes all of the study.
    """
    laws, all_positions, all_speeds = (list(dict.fromkeys(part)) for part in zip(*study.recordings, strict=True))
    columns = list(positions) if positions is not None else all_positions
    rows = list(speeds) if speeds is not None else all_speeds
    styles = law_styles(laws)
    with panels(len(rows), len(columns), size=(max(3.0 * len(columns), 5.0), 3.05 * len(rows) + 0.6)) as (figure, grid):
        for i, speed in enumerate(rows):
            factor = magnification_of(study, speed)
            for j, position in enumerate(columns):
                recordings = {law: study.recordings[law, position, speed] for law in laws}
                _draw(grid[i][j], recordings, factor, styles)
                grid[i][j].set_title(f"{position}, {speed * 1e3:g} mm/s, {scale_words(factor)}")
                grid[i][j].set_ylabel("y [mm]" if j == 0 else "")
                grid[-1][j].set_xlabel("x [mm]")
            _share_limits(grid[i])
    return figure


def paths_caption(study: CircleStudy) -> str:
    """What the figure shows, with its magnifications and where the largest deviation of each speed is."""
    speeds = sorted({speed for _, _, speed in study.recordings})
    factors = ", ".join(f"{scale_words(magnification_of(study, speed))} at {speed * 1e3:g} mm/s" for speed in speeds)
    styles = law_styles(law for law, _, _ in study.recordings)
    worst = [max(study.select(speed_mm_s=round(v * 1e3, 6)), key=lambda cell: cell.max_mm) for v in speeds]
    peaks = "; ".join(
        f"{cell.max_mm:.2f} mm at {cell.speed_mm_s:g} mm/s ({styles[cell.agent].label}, {cell.position}, "
        f"r = {cell.radius_mm:.3g} mm)"
        for cell in worst
    )
    return (
        "Seen along the normal of the circles. The deviation from the circle is drawn enlarged where it is small: "
        f"{factors}. The offset at standstill is removed; lead-in and lead-out are left out, so a path need not close. "
        f"Dashed: reference, r = {', '.join(f'{r:g}' for r in _radii(study))} mm. Largest deviation: {peaks}."
    )


def _draw(axes: "Axes", recordings: dict[str, Recording], factor: float, styles: dict[str, LawStyle]) -> None:
    """All laws at one position and speed."""
    widths = np.linspace(2.4, 1.0, len(recordings)) if len(recordings) > 1 else [1.3]  # what lies below shows beside
    for width, (law, recording) in zip(widths, recordings.items(), strict=True):
        circles = flat_circles(recording)
        for k, circle in enumerate(circles):
            path = circle.path(factor)[:: max(1, len(circle.angle) // _POINTS)]
            label = styles[law].label if k == 0 else None
            axes.plot(*path.T, color=styles[law].colour, linestyle=styles[law].line, linewidth=width, label=label)
    for k, circle in enumerate(circles):
        label = "reference circle" if k == 0 else None
        axes.plot(*circle.reference().T, color="black", linewidth=0.7, linestyle=(0, (5, 3)), label=label)


def _share_limits(row: "Sequence[Axes]") -> None:
    """Square limits, the same for all panels of a row, so that a millimetre is as long in x as in y."""
    reach = max(abs(limit) for axes in row for limit in (*axes.get_xlim(), *axes.get_ylim()))
    for axes in row:
        axes.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal")
        axes.locator_params(nbins=8, steps=[1, 2, 5, 10])


def _radii(study: CircleStudy) -> list[float]:
    return sorted({round(cell.radius_mm, 2) for cell in study.cells})


def _largest_factor(circle: FlatCircle, gap: float) -> float:
    """Factor with which a circle neither comes near its neighbours, `gap` [mm] away, nor near its own centre."""
    beside = magnification(0.9 * gap, float(np.abs(circle.outward).max()), MOST)
    return min(beside, magnification(0.95 * circle.radius, float(np.maximum(-circle.outward, 0.0).max()), MOST))


def _rows(recording: Recording, phase: Phase) -> BoolArray:
    return (recording.t >= phase.start) & (recording.t < phase.end)


def _plane(circle: Circle) -> Plane:
    """Plane of a circle, seen from the side on which the normal's largest part is positive (from above if level)."""
    upward = np.sign(circle.normal[np.argmax(np.abs(circle.normal))])
    return plane_of(upward * circle.normal)


def _flat(points: Array, circle: Circle, origin: Array, plane: Plane) -> FlatCircle:
    points = points[~np.isnan(points).any(axis=1)]
    axes = np.stack([plane.first, plane.second], axis=1)
    x, y = ((points - circle.centre) @ axes).T
    return FlatCircle(
        centre=(circle.centre - origin) @ axes * 1e3,
        radius=circle.radius * 1e3,
        angle=np.arctan2(y, x),
        outward=circle_deviation(points, circle)[0] * 1e3,
    )


def unit_vectors(angle: Array) -> Array:
    """Unit vectors in the directions of angles (T,) [rad], shape (T, 2)."""
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)
