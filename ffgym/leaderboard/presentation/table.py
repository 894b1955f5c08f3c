"""The page's table for one group of plants and one selection of circles, as words that need no more code."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, final

from ffgym.leaderboard.comparison.standings import Standing, Standings
from ffgym.leaderboard.presentation.columns import Column, columns_of
from ffgym.leaderboard.presentation.figures import Figure
from ffgym.leaderboard.presentation.published_rows import PublishedRow, published_rows
from ffgym.leaderboard.presentation.words import circles_note
from ffgym.leaderboard.results import Row


@final
@dataclass(frozen=True, kw_only=True)
class Line:
    """One row of the table."""

    kind: str
    """'ranked', 'shown' or 'published'."""
    name: str
    """Of the row; a published method's, with 'published_' before it."""
    track: str
    learned: bool
    """Whether it learned from motion of a machine, simulated or real."""
    cells: tuple[Figure, ...]


@final
@dataclass(frozen=True, kw_only=True)
class Table:
    """Columns and lines, in the order of the standings; published rows last."""

    key: str
    """Group and selection."""
    columns: tuple[Column, ...]
    lines: tuple[Line, ...]
    note: str
    """Which circles and plants, and who is missing."""

    def plain(self) -> dict[str, Any]:
        """As JSON holds it: a cell is [text, sort, detail, bar], shortened from the end."""
        heads = [[column.key, column.title, column.unit, int(column.is_text)] for column in self.columns]
        lines = [
            [line.kind, line.name, line.track, int(line.learned), [_plain(cell) for cell in line.cells]]
            for line in self.lines
        ]
        return {"columns": heads, "lines": lines, "note": self.note}


def table_of(standings: Standings) -> Table:
    """Table of standings."""
    columns = columns_of(standings)
    published = published_rows(standings.grid.cells)
    return Table(
        key=f"{standings.group}|{standings.selection}",
        columns=tuple(columns),
        lines=(*(_line(line, columns) for line in standings.lines), *(_published(row, columns) for row in published)),
        note=circles_note(standings, published),
    )


def learns(row: Row) -> bool:
    """Whether an agent learned from motion of a machine, simulated or real."""
    return any(outcome.robot_seconds > 0 or outcome.env_steps > 0 for outcome in row.outcomes)


def _line(line: Standing, columns: Sequence[Column]) -> Line:
    return Line(
        kind="shown" if line.rank is None else "ranked",
        name=line.row.name,
        track=line.row.track,
        learned=learns(line.row),
        cells=tuple(column.of(line) for column in columns),
    )


def _published(row: PublishedRow, columns: Sequence[Column]) -> Line:
    return Line(
        kind="published",
        name=f"published_{row.method}",
        track="published",
        learned=row.method.startswith("bsn"),
        cells=tuple(column.published(row) for column in columns),
    )


def _plain(cell: Figure) -> list[Any]:
    values: list[Any] = [cell.text, cell.sort, cell.detail, cell.bar]
    while len(values) > 1 and values[-1] in (None, ""):
        values.pop()
    return values
