"""Simulated path errors beside the published ones, circle by circle, as data and as tables."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import floor, log10
from statistics import fmean, median

from ffgym.published import published_mm
from ffgym.report.laws import UNCOMPENSATED, baseline_of, law_column, law_styles
from ffgym.report.page import words_of
from ffgym.report.table import Cell, Column, Table, pair, underline, wrap_text
from ffgym.studies import CircleStudy, OneAxisStudy

FACTOR = 1.5
"""Simulated and published numbers within this factor of one another count as near; chosen."""


@dataclass(frozen=True, kw_only=True)
class CircleEntry:
    """Path error of one circle with one law, in the plane of the circle [mm]."""

    rms: float
    max: float
    published_rms: float | None
    """Published RMS of the real robot; None if there is none."""
    published_max: float | None

    @property
    def ratio(self) -> float | None:
        """Simulated over published RMS."""
        return self.rms / self.published_rms if self.published_rms else None


@dataclass(frozen=True, kw_only=True)
class CircleRow:
    """One circle with every law."""

    position: str
    radius_mm: float
    entries: dict[str, CircleEntry]
    """Path errors by law."""


@dataclass(frozen=True, kw_only=True)
class SpeedTable:
    """All circles at one speed."""

    speed_mm_s: float
    agents: tuple[str, ...]
    rows: tuple[CircleRow, ...]
    """Circles by radius, then by position."""

    @property
    def is_published(self) -> bool:
        """True if the real robot was measured at this speed."""
        return any(entry.published_rms for row in self.rows for entry in row.entries.values())

    def mean_rms(self, agent: str) -> float | None:
        """Compute the mean simulated RMS over the circles [mm]; None without the law."""
        values = [row.entries[agent].rms for row in self.rows if agent in row.entries]
        return fmean(values) if values else None

    def mean_published_rms(self, agent: str) -> float | None:
        """Compute the mean published RMS over the same circles [mm]; None if a circle lacks a published number."""
        values = [row.entries[agent].published_rms for row in self.rows if agent in row.entries]
        known = [value for value in values if value is not None]
        return fmean(known) if known and len(known) == len(values) else None

    def max_error(self, agent: str) -> float | None:
        """Find the largest simulated deviation of all circles [mm]; None without the law."""
        return max((row.entries[agent].max for row in self.rows if agent in row.entries), default=None)

    def ratios(self, agent: str = UNCOMPENSATED) -> dict[tuple[float, str], float]:
        """Compute simulated over published RMS by radius [mm] and position, for published circles."""
        ratios = {(row.radius_mm, row.position): row.entries[agent].ratio for row in self.rows if agent in row.entries}
        return {key: ratio for key, ratio in ratios.items() if ratio is not None}


@dataclass(frozen=True, kw_only=True)
class Nearness:
    """Nearness of the simulated RMS to the published one on a set of circles."""

    near: int
    """Circles within FACTOR."""
    total: int
    median: float
    """Median of the ratios simulated over published."""


def nearness(ratios: Iterable[float]) -> Nearness | None:
    """Summarise ratios; return None if there are none."""
    values = list(ratios)
    if not values:
        return None
    near = sum(1 / FACTOR <= ratio <= FACTOR for ratio in values)
    return Nearness(near=near, total=len(values), median=median(values))


def circle_tables(study: CircleStudy) -> list[SpeedTable]:
    """Make one table per speed, slowest first, rows by radius and position, with every law of the study."""
    agents = tuple(dict.fromkeys(cell.agent for cell in study.cells))
    tables = []
    for speed in sorted({cell.speed_mm_s for cell in study.cells}):
        entries: dict[tuple[float, str], dict[str, CircleEntry]] = {}
        for cell in study.select(speed_mm_s=speed):
            where = (speed / 1e3, cell.radius_mm / 1e3, cell.position)
            entries.setdefault((cell.radius_mm, cell.position), {})[cell.agent] = CircleEntry(
                rms=cell.rms_mm,
                max=cell.max_mm,
                published_rms=published_mm(cell.agent, "rms", *where),
                published_max=published_mm(cell.agent, "max", *where),
            )
        ordered = sorted(entries.items(), key=lambda item: item[0][0])  # stable: positions stay in the study's order
        rows = tuple(
            CircleRow(position=position, radius_mm=radius, entries=laws) for (radius, position), laws in ordered
        )
        tables.append(SpeedTable(speed_mm_s=speed, agents=agents, rows=rows))
    return tables


def reduction(value: float | None, baseline: float | None) -> float | None:
    """Compute the reduction as a share of `baseline`, negative for growth; None if one is missing."""
    return None if value is None or not baseline else 1 - value / baseline


def percent(share: float) -> str:
    """Format a reduction: '53% less' for 0.53, '20% more' for -0.2, '99.7% less' for 0.997; 100 only for all."""
    digits = max(1, floor(-log10(1 - share)) - 1) if 0.98 <= share < 1 else 0
    return f"{abs(share):.{digits}%}" + (" less" if share >= 0 else " more")


def format_text(study: CircleStudy) -> str:
    """Format one table per speed: simulated beside published path error, and their ratio without compensation."""
    parts = [wrap_text(words_of("circles")["legend"].format(title=study.title))]
    for table in circle_tables(study):
        speed, near = f"{table.speed_mm_s:g} mm/s", nearness(table.ratios().values())
        if UNCOMPENSATED not in table.agents:
            words = f"No run without compensation (law {UNCOMPENSATED!r}), so none to compare with the published robot."
        elif near is None:
            words = f"Nothing to compare with: no numbers were published for these circles at {speed}."
        else:
            words = wrap_text(
                f"Ratio simulated / published RMS without compensation: median {near.median:.2f}; {near.near} of "
                f"{near.total} circles within a factor of {FACTOR:g} ({1 / FACTOR:.2f} to {FACTOR:g})"
            )
        parts += [f"{underline(speed)}\n{speed_table(table).text()}", words]
    return "\n\n".join(parts) + "\n"


def format_one_axis(study: OneAxisStudy) -> str:
    """Format the motor error of the sine test, one line per frequency and law."""
    legend = wrap_text(words_of("circles")["sine_legend"].format(title=study.robot.title))
    return f"{legend}\n\n{sine_table(study).text()}\n"


def speed_table(table: SpeedTable, *, with_ratio: bool = True) -> Table:
    """Tabulate every circle at one speed, simulated beside published, and their ratio without compensation."""
    rows, styles = table.rows, law_styles(table.agents)
    columns = [
        Column("r", [*(row.radius_mm for row in rows), "mean"], "g", unit="mm"),
        Column("position", [*(row.position for row in rows), "all"], kind="name"),
    ]
    # simulated and published errors of each law, with means
    for agent, style in styles.items():
        entries = [row.entries.get(agent) for row in rows]
        simulated = [entry and pair(entry.rms, entry.max, ".3f") for entry in entries]
        published = [entry and pair(entry.published_rms, entry.published_max, ".3f", ".2f") for entry in entries]
        means = table.mean_rms(agent), table.mean_published_rms(agent)
        columns += [
            Column("simulated", [*simulated, means[0]], ".3f", group=style.label, colour=style.colour),
            Column("published", [*published, means[1]], ".3f", group=style.label, style="published"),
        ]
    near = nearness(table.ratios().values())
    if with_ratio and near is not None:
        ratios = [table.ratios().get((row.radius_mm, row.position)) for row in rows]
        median = Cell(f"median {near.median:.2f}")
        columns.append(Column(f"ratio, {styles[UNCOMPENSATED].label}", [*ratios, median], ".2f", style="edge"))
    return Table(columns=columns, fixed=2, ruled_by=0, strong=[-1])


def sine_table(study: OneAxisStudy) -> Table:
    """Tabulate the motor error at each frequency with each law."""
    results = study.results
    return Table(
        columns=[
            Column("f", [result.frequency_hz for result in results], "g", unit="Hz"),
            law_column("law", [result.agent for result in results]),
            Column("RMS", [result.motor_rms_rad * 1e3 for result in results], ".3f", unit="mrad"),
            Column("max", [result.motor_max_rad * 1e3 for result in results], ".3f", unit="mrad"),
            Column("RMS removed", [result.reduction for result in results], ".1%"),
        ],
        name="sines",
        fixed=2,
        ruled_by=0,
    )


def summary_table(tables: Sequence[SpeedTable]) -> Table:
    """Tabulate mean RMS and change, simulated and published, one line per speed and law."""
    lines = [(table, agent, baseline_of(table.agents)) for table in tables for agent in table.agents]
    columns = [
        Column("speed", [table.speed_mm_s for table, _, _ in lines], "g", unit="mm/s"),
        law_column("law", [agent for _, agent, _ in lines]),
    ]
    for group, style, mean in (
        ("simulated", "", SpeedTable.mean_rms),
        ("published", "published", SpeedTable.mean_published_rms),
    ):
        changes = [None if law == base else reduction(mean(t, law), mean(t, base)) for t, law, base in lines]
        words = [None if change is None else percent(change) for change in changes]
        columns += [
            Column("mean RMS", [mean(t, law) for t, law, _ in lines], ".3f", unit="mm", group=group, style=style),
            Column("change", words, group=group, style=style),
        ]
    return Table(columns=columns, name="summary", fixed=2, ruled_by=0)
