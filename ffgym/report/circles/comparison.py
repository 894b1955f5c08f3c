"""Simulated path errors beside the published ones, circle by circle, as plain data."""

from collections.abc import Iterable
from dataclasses import dataclass
from math import floor, log10
from statistics import fmean, median

from ffgym.published import published_mm
from ffgym.report.laws import UNCOMPENSATED
from ffgym.studies import CircleStudy

FACTOR = 1.5
"""Simulated and published numbers within this factor of one another count as near; chosen."""


@dataclass(frozen=True, kw_only=True)
class Entry:
    """Path error of one circle with one law, in the plane of the circle [mm]."""

    rms: float
    max: float
    published_rms: float | None
    """Of the real robot, None where nothing was published."""
    published_max: float | None

    @property
    def ratio(self) -> float | None:
        """Simulated over published RMS."""
        return self.rms / self.published_rms if self.published_rms else None


@dataclass(frozen=True, kw_only=True)
class Row:
    """One circle with every law."""

    position: str
    radius_mm: float
    entries: dict[str, Entry]
    """By law."""


@dataclass(frozen=True, kw_only=True)
class SpeedTable:
    """All circles at one speed."""

    speed_mm_s: float
    agents: tuple[str, ...]
    rows: tuple[Row, ...]
    """By radius, then by position."""

    @property
    def is_published(self) -> bool:
        """Whether the real robot was measured at this speed."""
        return any(entry.published_rms for row in self.rows for entry in row.entries.values())

    def mean_rms(self, agent: str) -> float | None:
        """Mean simulated RMS over the circles [mm]; None without the law."""
        values = [row.entries[agent].rms for row in self.rows if agent in row.entries]
        return fmean(values) if values else None

    def mean_published_rms(self, agent: str) -> float | None:
        """Mean published RMS over the same circles [mm]; None where a circle lacks a published number."""
        values = [row.entries[agent].published_rms for row in self.rows if agent in row.entries]
        known = [value for value in values if value is not None]
        return fmean(known) if known and len(known) == len(values) else None

    def max_error(self, agent: str) -> float | None:
        """Largest simulated deviation of all circles [mm]; None without the law."""
        return max((row.entries[agent].max for row in self.rows if agent in row.entries), default=None)

    def ratios(self, agent: str = UNCOMPENSATED) -> dict[tuple[float, str], float]:
        """Simulated over published RMS by radius [mm] and position, where something was published."""
        ratios = {(row.radius_mm, row.position): row.entries[agent].ratio for row in self.rows if agent in row.entries}
        return {key: ratio for key, ratio in ratios.items() if ratio is not None}


@dataclass(frozen=True, kw_only=True)
class Nearness:
    """How near the simulated RMS of a set of circles is to the published one."""

    near: int
    """Circles within FACTOR."""
    total: int
    median: float
    """Of the ratios simulated over published."""


def nearness(ratios: Iterable[float]) -> Nearness | None:
    """Summary of ratios; None if there are none."""
    values = list(ratios)
    if not values:
        return None
    near = sum(1 / FACTOR <= ratio <= FACTOR for ratio in values)
    return Nearness(near=near, total=len(values), median=median(values))


def circle_tables(study: CircleStudy) -> list[SpeedTable]:
    """One table per speed, slowest first, rows by radius and position, with every law of the study."""
    agents = tuple(dict.fromkeys(cell.agent for cell in study.cells))
    tables = []
    for speed in sorted({cell.speed_mm_s for cell in study.cells}):
        entries: dict[tuple[float, str], dict[str, Entry]] = {}
        for cell in study.select(speed_mm_s=speed):
            where = (speed / 1e3, cell.radius_mm / 1e3, cell.position)
            entries.setdefault((cell.radius_mm, cell.position), {})[cell.agent] = Entry(
                rms=cell.rms_mm,
                max=cell.max_mm,
                published_rms=published_mm(cell.agent, "rms", *where),
                published_max=published_mm(cell.agent, "max", *where),
            )
        ordered = sorted(entries.items(), key=lambda item: item[0][0])  # stable: positions stay in the study's order
        rows = tuple(Row(position=position, radius_mm=radius, entries=laws) for (radius, position), laws in ordered)
        tables.append(SpeedTable(speed_mm_s=speed, agents=agents, rows=rows))
    return tables


def reduction(value: float | None, baseline: float | None) -> float | None:
    """Share of `baseline` that is gone, negative if it has grown; None if one is missing."""
    return None if value is None or not baseline else 1 - value / baseline


def percent(share: float) -> str:
    """A reduction in words: '53% less' for 0.53, '20% more' for -0.2, '99.7% less' for 0.997, never 100 but for all."""
    digits = max(1, floor(-log10(1 - share)) - 1) if 0.98 <= share < 1 else 0
    return f"{abs(share):.{digits}%}" + (" less" if share >= 0 else " more")
