"""Standings as a table, on the page and in a terminal: columns, and the figures of each row."""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

from ffgym.leaderboard.comparison.standings import AgainstBase, Standing, Standings
from ffgym.leaderboard.presentation.figures import (
    NOTHING,
    Figure,
    change,
    count,
    digits,
    duration,
    length,
    length_with_change,
    share,
    sortable,
)
from ffgym.leaderboard.presentation.words import (
    SELECTION_TITLES,
    PublishedRow,
    circles_note,
    group_title,
    list_published_rows,
    margins_sentence,
    residual_sentence,
)
from ffgym.leaderboard.results import CHANNEL_TITLES, Row
from ffgym.report import table as report
from ffgym.report.page import resource


@dataclass(frozen=True, kw_only=True)
class StandingsColumn:
    """One column, see leaderboard_columns.toml."""

    key: str
    title: str
    unit: str = ""
    help: str
    is_text: bool = False
    in_terminal: bool = False


@dataclass(frozen=True, kw_only=True)
class StandingsLine:
    """One row of the table."""

    kind: str
    """'ranked', 'shown' or 'published'."""
    name: str
    """Name of the row; a published method's with the prefix 'published_'."""
    control: str
    """Track: feed-forward, with feedback, or published."""
    track: str
    """What it may know."""
    channel: str
    """Title of the channel that it acts through; published methods add torque."""
    learned: bool
    """True if it learned from motion of a machine, simulated or real."""
    cells: tuple[Figure, ...]


@dataclass(frozen=True, kw_only=True)
class StandingsTable:
    """Columns and lines, in the order of the standings; published rows last."""

    key: str
    """Group and selection."""
    columns: tuple[StandingsColumn, ...]
    lines: tuple[StandingsLine, ...]
    note: str
    """Circles, plants, and rows that are left out."""

    def plain(self) -> dict[str, Any]:
        """Convert to JSON: a cell is [text, sort, detail, bar], shortened from the end."""
        heads = [[column.key, column.title, column.unit, int(column.is_text)] for column in self.columns]
        lines = []
        for line in self.lines:
            cells: list[list[Any]] = [[cell.text, cell.sort, cell.detail, cell.bar] for cell in line.cells]
            for cell in cells:
                while len(cell) > 1 and cell[-1] in (None, ""):
                    cell.pop()
            lines.append([line.kind, line.name, line.control, int(line.learned), cells, line.track, line.channel])
        return {"columns": heads, "lines": lines, "note": self.note}


@cache
def every_column() -> tuple[StandingsColumn, ...]:
    """Read all columns, those of speeds as one."""
    return tuple(StandingsColumn(**entry) for entry in tomllib.loads(resource("leaderboard_columns.toml"))["column"])


def list_columns(standings: Standings) -> list[StandingsColumn]:
    """List all columns, with one per speed."""
    columns = []
    for column in every_column():
        if column.key == "speed":
            titles = {f"speed{speed:g}": f"{speed:g} mm/s" for speed in standings.grid.speeds_mm_s}
            columns += [replace(column, key=key, title=title) for key, title in titles.items()]
        else:
            columns.append(column)
    return columns


def table_of(standings: Standings) -> StandingsTable:
    """Make the table of standings."""
    columns, published = list_columns(standings), list_published_rows(standings.grid.cells)

    def cells(figures: Mapping[str, Figure]) -> tuple[Figure, ...]:
        return tuple(figures.get(column.key, NOTHING) for column in columns)

    # rows of the standings, then published methods
    lines = [
        StandingsLine(
            kind="shown" if line.rank is None else "ranked",
            name=line.row.name,
            control=line.row.control,
            track=line.row.track,
            channel=CHANNEL_TITLES[line.row.channel],
            learned=any(outcome.robot_seconds > 0 or outcome.env_steps > 0 for outcome in line.row.outcomes),
            cells=cells(_figures(line)),
        )
        for line in standings.lines
    ]
    lines += [
        StandingsLine(
            kind="published",
            name=f"published_{row.method}",
            control="published",
            track="published",
            channel=CHANNEL_TITLES["torque"],
            learned=row.method.startswith("bsn"),
            cells=cells(_figures_of_thesis(row)),
        )
        for row in published
    ]
    return StandingsTable(
        key=f"{standings.group}|{standings.selection}",
        columns=tuple(columns),
        lines=tuple(lines),
        note=circles_note(standings, published),
    )


def _figures(line: Standing) -> dict[str, Figure]:
    """Compute the figures of a row by the key of their column."""
    row, score = line.row, line.score
    time = score.inference_us
    return {f"speed{each.speed_mm_s:g}": length_with_change(each.rms_um, each.reduction) for each in score.speeds} | {
        "rank": _rank(line.rank),
        "agent": Figure(text=row.title, detail=f"on {row.base}" if row.base else "", sort=row.title.lower()),
        "left": share(score.left, score.left_interval, bar=True),
        "iqm": length(score.iqm_um, score.iqm_interval_um),
        "iqm3d": length(score.iqm_3d_um),
        "largest": length(score.max_um),
        "motor": length(max(score.motor_mrad, default=float("inf"))),
        "worse": Figure(
            text=f"{score.worse:.1%}"[:-1],
            detail=f"{score.stopped:.1%} stopped" if score.stopped else "",
            sort=sortable(score.worse),
        ),
        "score": NOTHING if score.normalised is None else length(score.normalised),
        "gain": _gain_margin(row),
        "delay": _delay_margin(row),
        "base": NOTHING if line.against_base is None else _against(line.against_base),
        "control": Figure(text=row.control, sort=row.control),
        "channel": _channel(row),
        "track": Figure(text=row.track, sort=row.track),
        "within": _rank(line.track_rank),
        "seeds": Figure(text=str(len(score.seeds)), sort=len(score.seeds)),
        "robot": Figure(text=duration(score.robot_seconds), sort=sortable(score.robot_seconds)),
        "steps": Figure(text=count(score.env_steps), sort=sortable(score.env_steps)),
        "decision": NOTHING if time is None else Figure(text=digits(time), sort=time),
    }


def _figures_of_thesis(row: PublishedRow) -> dict[str, Figure]:
    """Compute the figures of a method of the thesis by the key of their column."""
    return {f"speed{each.speed_mm_s:g}": length_with_change(each.rms_um, each.reduction) for each in row.speeds} | {
        "agent": Figure(text=row.title, detail="published, real robot", sort=row.title.lower()),
        "largest": NOTHING if row.max_um is None else length(row.max_um),
        "control": Figure(text="published", sort="published"),
        "channel": Figure(text=CHANNEL_TITLES["torque"], sort=CHANNEL_TITLES["torque"]),
        "track": Figure(text="published", sort="published"),
    }


def _rank(rank: int | None) -> Figure:
    return Figure(text="–" if rank is None else str(rank), sort=rank)


def _channel(row: Row) -> Figure:
    """Name the channel of a row, and how late its set-points are at low frequencies."""
    title, late = CHANNEL_TITLES[row.channel], 0.0 if row.setpoints is None else row.setpoints.lateness_ms
    return Figure(text=title, detail=f"+{late:g} ms" if late else "", sort=title)


def _gain_margin(row: Row) -> Figure:
    """Format the smallest gain margin of the seeds; nothing where there is none."""
    if not row.margins:
        return NOTHING
    least = min(each.gain for each in row.margins)
    return Figure(text=digits(least), sort=sortable(least))


def _delay_margin(row: Row) -> Figure:
    """Format the smallest delay margin of the seeds; nothing where there is none."""
    if not row.margins:
        return NOTHING
    delays = [each.delay_ms for each in row.margins if each.delay_ms is not None]
    if len(delays) < len(row.margins):
        return Figure(text="none", sort=-1.0)
    return Figure(text=f"{min(delays):g}", sort=sortable(min(delays)))


def _against(found: AgainstBase) -> Figure:
    if found.difference is None:
        return Figure(text=found.sentence)
    ratio = found.difference.ratio
    return Figure(text=found.sentence, detail=change(ratio - 1), sort=sortable(ratio))


_LEGEND = (
    "error left: geometric mean of RMS path error / that with zero action over seeds, plants and circles, with its "
    "95 % interval; rows are ranked by it, ties share a rank. At each speed: mean RMS path error and its change. "
    "'-' as rank: shown only."
)
"""Explanation below a table in a terminal."""


def format_standings(standings: Standings) -> str:
    """Format standings as text of at most 120 columns: rank, agent and figures; those that do not fit go below."""
    title = f"{group_title(standings.group)}; {SELECTION_TITLES[standings.selection]}"
    lines, figures = standings.lines, [_figures(line) for line in standings.lines]
    table = report.Table(
        columns=[
            report.Column("rank", [line.rank for line in lines]),
            report.Column("agent", [line.row.name for line in lines], kind="name"),
            *(
                report.Column(
                    column.title,
                    [own[column.key] for own in figures],
                    unit=column.unit,
                    kind="text" if column.is_text else "number",
                )
                for column in list_columns(standings)
                if column.in_terminal
            ),
        ],
        fixed=2,
    )
    told = (residual_sentence(standings), margins_sentence(standings))
    words = [_LEGEND, *(each for each in told if each is not None), circles_note(standings)]
    text = "\n".join([report.underline(title), table.text(), "", *map(report.wrap_text, words)])
    for sign, plain in (("−", "-"), ("–", "-"), ("“", "'"), ("”", "'"), ("±", "")):  # a terminal may know ASCII only
        text = text.replace(sign, plain)
    return text
