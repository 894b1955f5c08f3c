"""Standings as plain text for a terminal, at most 120 columns wide."""

from ffgym.leaderboard.comparison.standings import Standings
from ffgym.leaderboard.presentation.columns import columns_of
from ffgym.leaderboard.presentation.words import SELECTION_TITLES, circles_note, group_title, residual_sentence
from ffgym.report.table import Column, Table, filled, underlined

_KEYS = ("left", "iqm", "largest", "worse", "score", "seeds", "robot", "steps", "decision")
"""Columns of the page that a terminal gets too."""
_LEGEND = (
    "error left: geometric mean of RMS path error / that with zero action over seeds, plants and circles, with its "
    "95 % interval; rows are ranked by it, ties share a rank. At each speed: mean RMS path error and its change. "
    "'-' as rank: shown only."
)
"""How to read it."""


def format_standings(standings: Standings) -> str:
    """One table: rank, agent, and figures side by side; what does not fit goes below."""
    title = f"{group_title(standings.group)}; {SELECTION_TITLES[standings.selection]}"
    lines = standings.lines
    columns = {column.key: column for column in columns_of(standings)}
    left, *others = (columns[key] for key in _KEYS)
    speeds = [columns[f"speed{speed:g}"] for speed in standings.grid.speeds_mm_s]
    table = Table(
        columns=[
            Column("rank", [None if line.rank is None else line.rank for line in lines]),
            Column("agent", [line.row.name for line in lines], kind="name"),
            *(
                Column(each.title, [each.of(line) for line in lines], unit=each.unit)
                for each in (left, *speeds, *others)
            ),
        ],
        fixed=2,
    )
    told = residual_sentence(standings)
    words = [_LEGEND, *([] if told is None else [told]), circles_note(standings)]
    parts = [underlined(title), table.text(), "", *map(filled, words)]
    return "\n".join(_plain(part) for part in parts)


def _plain(text: str) -> str:
    """With the signs of a terminal."""
    for sign, plain in (("−", "-"), ("–", "-"), ("“", "'"), ("”", "'"), ("±", "")):
        text = text.replace(sign, plain)
    return text
