"""The path of the tool on the circles, with the path error magnified: thesis Figures 4.6a to 4.12a."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.paths.circles import plane_of
from ffgym.recordings import Recording
from ffgym.recordings.metrics import circle_deviation, fit_circle, magnification, magnify, standstill_offset
from ffgym.report.figure import ReportFigure, panels
from ffgym.report.laws import LawStyle, law_styles
from ffgym.report.tool_path import scale_words
from ffgym.studies import CircleStudy

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST = 100.0
"""Largest factor that a path error is drawn with."""
_POINTS = 600
"""Points drawn on one circle, enough for a line without corners."""


@dataclass(frozen=True, kw_only=True, eq=False)
class FlatCircle:
    """One circle of a recording seen along its normal; T samples."""

    centre: Array
    """Centre relative to that of the first circle [mm], shape (2,)."""
    radius: float
    """Radius [mm]."""
    angle: Array
    """Angle of the tool on the circle [rad], shape (T,)."""
    outward: Array
    """Deviation in the plane, offset at standstill removed [mm], shape (T,)."""

    def path(self, magnification: float) -> Array:
        """Compute the path of the tool [mm] with its deviation enlarged, shape (T, 2)."""
        outwards = unit_vectors(self.angle)
        return magnify(self.centre + self.radius * outwards, self.outward[:, None] * outwards, magnification)

    def reference(self) -> Array:
        """Compute points of the circle [mm], shape (200, 2)."""
        return self.centre + self.radius * unit_vectors(np.linspace(0, 2 * np.pi, 200))


def flat_circles(recording: Recording) -> list[FlatCircle]:
    """Extract every circle of a recording, without lead-in and lead-out.

    They are seen from the side on which the largest part of the first one's normal is positive (from above if level).
    """
    phases = recording.phases_of("circle")
    if not phases:
        raise FFGymError(f"Recording {recording.header.segment!r} has no phase of kind 'circle' to draw.")
    tcp = recording.vector("tcp.position") - standstill_offset(recording)
    reference = recording.vector("tcp_reference.position")
    stretches = [(recording.t >= phase.start) & (recording.t < phase.end) for phase in phases]
    # plane of the first circle
    fits = [fit_circle(reference[rows]) for rows in stretches]
    origin, normal = fits[0].centre, fits[0].normal
    plane = plane_of(np.sign(normal[np.argmax(np.abs(normal))]) * normal)
    axes = np.stack([plane.first, plane.second], axis=1)
    # deviation of the tool from each circle in that plane
    flat = []
    for rows, fit in zip(stretches, fits, strict=True):
        points = tcp[rows][~np.isnan(tcp[rows]).any(axis=1)]
        x, y = ((points - fit.centre) @ axes).T
        flat.append(
            FlatCircle(
                centre=(fit.centre - origin) @ axes * 1e3,
                radius=fit.radius * 1e3,
                angle=np.arctan2(y, x),
                outward=circle_deviation(points, fit)[0] * 1e3,
            )
        )
    return flat


def choose_magnification(study: CircleStudy, speed: float) -> float:
    """Find the largest factor at `speed` [m/s] with which no circle comes near its neighbours or its own centre."""
    recordings = [recording for (_, _, v), recording in study.recordings.items() if v == speed]
    circles = [circle for recording in recordings for circle in flat_circles(recording)]
    radii = sorted({round(circle.radius, 2) for circle in circles})
    gap = float(np.diff([0.0, *radii]).max() if len(radii) < 3 else np.median(np.diff(radii)))
    factors = []
    for circle in circles:
        factors.append(magnification(0.9 * gap, float(np.abs(circle.outward).max()), MOST))
        factors.append(magnification(0.95 * circle.radius, float(np.maximum(-circle.outward, 0.0).max()), MOST))
    return min(factors)


def paths_figure(study: CircleStudy) -> ReportFigure:
    """Draw paths of every law: one row per speed, one column per position."""
    laws, columns, rows = (list(dict.fromkeys(part)) for part in zip(*study.recordings, strict=True))
    styles, factors = law_styles(laws), {speed: choose_magnification(study, speed) for speed in rows}
    with panels(len(rows), len(columns), size=(max(3.0 * len(columns), 5.0), 3.05 * len(rows) + 0.6)) as (figure, grid):
        for i, speed in enumerate(rows):
            for j, position in enumerate(columns):
                recordings = {law: study.recordings[law, position, speed] for law in laws}
                _draw(grid[i][j], recordings, factors[speed], styles)
                grid[i][j].set_title(f"{position}, {speed * 1e3:g} mm/s, {scale_words(factors[speed])}")
                grid[i][j].set_ylabel("y [mm]" if j == 0 else "")
                grid[-1][j].set_xlabel("x [mm]")
            # square limits, the same for all panels of a row, so that a millimetre is as long in x as in y
            reach = max(abs(limit) for axes in grid[i] for limit in (*axes.get_xlim(), *axes.get_ylim()))
            for axes in grid[i]:
                axes.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal")
                axes.locator_params(nbins=8, steps=[1, 2, 5, 10])
    # scale and largest deviation at each speed, for the caption
    scales, peaks = [], []
    for speed in sorted(rows):
        scales.append(f"{scale_words(factors[speed])} at {speed * 1e3:g} mm/s")
        worst = max(study.select(speed_mm_s=round(speed * 1e3, 6)), key=lambda cell: cell.max_mm)
        where = f"{styles[worst.agent].label}, {worst.position}, r = {worst.radius_mm:.3g} mm"
        peaks.append(f"{worst.max_mm:.2f} mm at {worst.speed_mm_s:g} mm/s ({where})")
    radii = ", ".join(f"{r:g}" for r in sorted({round(cell.radius_mm, 2) for cell in study.cells}))
    return ReportFigure(
        name="paths",
        title="Path of the tool",
        caption="Seen along the normal of the circles. The deviation from the circle is drawn enlarged where it is "
        f"small: {', '.join(scales)}. The offset at standstill is removed; lead-in and lead-out are left out, so a "
        f"path need not close. Dashed: reference, r = {radii} mm. Largest deviation: {'; '.join(peaks)}.",
        figure=figure,
        thesis="Figures 4.6a to 4.9a (simulated), 4.10a to 4.12a (real robot)",
    )


def _draw(axes: "Axes", recordings: dict[str, Recording], factor: float, styles: dict[str, LawStyle]) -> None:
    """Draw all laws at one position and speed."""
    widths = (
        np.linspace(2.4, 1.0, len(recordings)) if len(recordings) > 1 else [1.3]
    )  # lower lines stay visible beside upper ones
    for width, (law, recording) in zip(widths, recordings.items(), strict=True):
        circles = flat_circles(recording)
        for k, circle in enumerate(circles):
            path = circle.path(factor)[:: max(1, len(circle.angle) // _POINTS)]
            label = styles[law].label if k == 0 else None
            axes.plot(*path.T, color=styles[law].colour, linestyle=styles[law].line, linewidth=width, label=label)
    for k, circle in enumerate(circles):
        label = "reference circle" if k == 0 else None
        axes.plot(*circle.reference().T, color="black", linewidth=0.7, linestyle=(0, (5, 3)), label=label)


def unit_vectors(angle: Array) -> Array:
    """Compute unit vectors in the directions of angles (T,) [rad], shape (T, 2)."""
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)
