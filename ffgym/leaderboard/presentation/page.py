"""The leaderboard as one HTML page that needs nothing else and asks for nothing else."""

import base64
import hashlib
import json
from collections.abc import Mapping, Sequence
from typing import Any

from ffgym.leaderboard.comparison.samples import GROUPS, SELECTIONS, grid_of, groups_of
from ffgym.leaderboard.comparison.standings import Standings, standings
from ffgym.leaderboard.presentation.cards import cards_of
from ffgym.leaderboard.presentation.columns import explanations
from ffgym.leaderboard.presentation.pictures import FORMS, ToolPaths, glance
from ffgym.leaderboard.presentation.pictures import ToolPath as ToolPath
from ffgym.leaderboard.presentation.table import Table, table_of
from ffgym.leaderboard.presentation.words import SELECTION_TITLES, group_title, headline, residual_sentence
from ffgym.leaderboard.results import Row
from ffgym.leaderboard.tasks import HELD_OUT
from ffgym.report.laws import UNCOMPENSATED
from ffgym.report.page import provenance_lines, render, resource


def render_page(
    rows: Sequence[Row],
    *,
    tracks: ToolPaths | None = None,
    provenance: Mapping[str, Any],
    agent_pages: str = "../agents/",
) -> str:
    """HTML of the leaderboard; the same rows, in whatever order, give the same text.

    Args:
        rows: with different names, among them the zero action 'none'.
        tracks: path of the tool by row name and TCP speed [mm/s]; rows without one have no picture.
        provenance: where the numbers come from, by name; a dict in it gives a line per entry.
        agent_pages: where links to the agents' pages begin, from where this page will lie.

    Raises:
        FFGymError: if rows cannot be compared, or matplotlib or jinja2 is missing.
    """
    every = all_standings(rows)
    tables = [table_of(each) for each in every]
    first, held_out = every[0], _held_out(every)
    script = resource("leaderboard.js")
    on_workcell = [each for each in every if (each.group, each.selection) == (GROUPS[0], "positions")]
    return render(
        "leaderboard.html.j2",
        headline=headline(on_workcell[0] if on_workcell else None),
        residuals=residual_sentence(first),
        standings=first,
        table=tables[0],
        glance=glance(first),
        forms=FORMS,
        overview_circles=f"{group_title(first.group)}, {SELECTION_TITLES[first.selection]}",
        explanations=explanations(tables[0].columns),
        cards=cards_of(rows, held_out, tracks or {}),
        groups=[(group, group_title(group)) for group in dict.fromkeys(each.group for each in every)],
        selections=[(name, SELECTION_TITLES[name]) for name in dict.fromkeys(each.selection for each in every)],
        tracks=sorted({line.track for table in tables for line in table.lines}),
        where="; ".join(sorted({path.where for own in (tracks or {}).values() for path in own.values() if path.where})),
        agent_pages=agent_pages,
        style=resource("leaderboard.css"),
        script=script,
        script_hash=_hash(script),
        data=_json(tables),
        provenance=provenance_lines(provenance),
    )


def all_standings(rows: Sequence[Row]) -> list[Standings]:
    """Standings on every group of plants and selection of circles that the zero action was run on."""
    found = [
        standings(rows, group, selection)
        for row in rows
        if row.name == UNCOMPENSATED
        for group in groups_of(row)
        for selection in SELECTIONS
        if grid_of(row, group, SELECTIONS[selection]).cells
    ]
    return found or [standings(rows, GROUPS[0], next(iter(SELECTIONS)))]  # which tells what is missing


def _held_out(every: Sequence[Standings]) -> list[Standings]:
    """Of each group those on the most circles that nobody learned on; selections are in the order of what counts."""
    first: dict[str, Standings] = {}
    for each in every:
        if set(SELECTIONS[each.selection]) <= set(HELD_OUT):
            first.setdefault(each.group, each)
    return list(first.values())


def _json(tables: Sequence[Table]) -> str:
    """Data that cannot end the script it stands in, whatever a row is called."""
    text = json.dumps({table.key: table.plain() for table in tables}, separators=(",", ":"), allow_nan=False)
    return text.replace("&", "\\u0026").replace("<", "\\u003c").replace(">", "\\u003e")


def _hash(script: str) -> str:
    """Of the only script that the page's policy lets run."""
    return "sha256-" + base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
