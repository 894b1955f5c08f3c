"""What the thesis published of the real robot, as rows of reference: another machine, never ranked."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import fsum

from ffgym.leaderboard.comparison.samples import CellKey
from ffgym.leaderboard.tasks import THESIS
from ffgym.paths import RADII, SPEEDS
from ffgym.published import METHODS, published_mm
from ffgym.report.laws import UNCOMPENSATED, law_styles
from ffgym.studies import in_mm

_POSITIONS = ("p1", "p2", "p3", "p4")
"""Corners of the work area (thesis, 2.2.5)."""


@dataclass(frozen=True, kw_only=True)
class PublishedSpeed:
    """Mean of published RMS path errors at one speed."""

    speed_mm_s: float
    rms_um: float
    reduction: float
    """Share of the mean without compensation on the same circles that is gone."""
    circles: int


@dataclass(frozen=True, kw_only=True)
class PublishedRow:
    """One method of the thesis on the real robot."""

    method: str
    title: str
    speeds: tuple[PublishedSpeed, ...]
    max_um: float | None
    """Largest published deviation; None if none was published."""


def published_rows(cells: Sequence[CellKey]) -> list[PublishedRow]:
    """Methods of the thesis on those of the circles that it measured; none if it measured none of them."""
    styles = law_styles(METHODS)
    rows = [
        PublishedRow(
            method=method,
            title=styles[method].label,
            speeds=_speeds(method, cells),
            max_um=max((x * 1e3 for cell in cells if (x := _published(method, "max", cell)) is not None), default=None),
        )
        for method in METHODS
    ]
    return [row for row in rows if row.speeds]


def best_reductions() -> dict[float, tuple[str, float]]:
    """Best published method and its reduction of the mean over all circles, by TCP speed [mm/s]."""
    cells = [(THESIS[0], p, in_mm(r), in_mm(v)) for v in SPEEDS for r in RADII for p in _POSITIONS]
    best: dict[float, tuple[str, float]] = {}
    for row in published_rows(cells):
        for each in row.speeds:
            if each.speed_mm_s not in best or each.reduction > best[each.speed_mm_s][1]:
                best[each.speed_mm_s] = (row.title, each.reduction)
    return best


def _speeds(method: str, cells: Sequence[CellKey]) -> tuple[PublishedSpeed, ...]:
    """Means of a method at the speeds of some circles, over those that were measured with and without it."""
    found = []
    for speed in sorted({speed for *_, speed in cells}):
        own = [cell for cell in cells if cell[3] == speed]
        pairs = [(_published(method, "rms", cell), _published(UNCOMPENSATED, "rms", cell)) for cell in own]
        known = [(value, zero) for value, zero in pairs if value is not None and zero is not None]
        if known:
            total, zero = fsum(value for value, _ in known), fsum(zero for _, zero in known)
            mean, n = total / len(known) * 1e3, len(known)
            found.append(PublishedSpeed(speed_mm_s=speed, rms_um=mean, reduction=1 - total / zero, circles=n))
    return tuple(found)


def _published(method: str, statistic: str, cell: CellKey) -> float | None:
    """Published error [mm] on a circle."""
    _, position, radius, speed = cell
    return published_mm(method, statistic, speed / 1e3, radius / 1e3, position)
