"""Page of the leaderboard: one HTML file that loads no other."""

import base64
import hashlib
import json
from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

from ffgym.leaderboard.comparison.samples import GROUPS, HEADLINED, SELECTIONS, collect_grid, groups_of
from ffgym.leaderboard.comparison.standings import Standing, Standings, standings
from ffgym.leaderboard.presentation.adaptation import AdaptationPicture
from ffgym.leaderboard.presentation.figures import count, digits, duration, length_with_change, share
from ffgym.leaderboard.presentation.pictures import (
    LearningCurve,
    Picture,
    ToolTraces,
    glance,
    learning_curve,
    tool_pictures,
)
from ffgym.leaderboard.presentation.pictures import ToolTrace as ToolTrace
from ffgym.leaderboard.presentation.table import every_column, table_of
from ffgym.leaderboard.presentation.words import (
    SELECTION_TITLES,
    group_title,
    headline,
    margins_sentence,
    residual_sentence,
)
from ffgym.leaderboard.results import Row
from ffgym.leaderboard.tasks import HELD_OUT
from ffgym.report.laws import UNCOMPENSATED
from ffgym.report.page import provenance_lines, render, resource

Card: TypeAlias = tuple[Row, list[tuple[str, Standing]], LearningCurve | None, list[Picture]]
"""A row with its places on held-out circles by group of plants, its learning curve and paths of the tool."""


def render_page(
    rows: Sequence[Row],
    *,
    tracks: ToolTraces | None = None,
    provenance: Mapping[str, Any],
    agent_pages: str = "../agents/",
    adaptation: AdaptationPicture | None = None,
) -> str:
    """Render the leaderboard as HTML; the same rows, in any order, give the same text.

    Args:
        rows: rows with different names, among them the zero action 'none'.
        tracks: path of the tool by row name and TCP speed [mm/s]; rows without one have no picture.
        provenance: origin of the numbers, by name; a dict in it gives a line per entry.
        agent_pages: start of the links to the agents' pages, relative to the place of this page.
        adaptation: curve of adaptation; without it the page has none.

    Raises:
        FFGymError: if rows cannot be compared, or matplotlib or jinja2 is missing.
    """
    every, paths = all_standings(rows), tracks or {}
    tables = [table_of(each) for each in every]
    first, script = every[0], resource("leaderboard.js")
    headlined = [each for each in every if each.group in HEADLINED and each.selection == "positions"]
    # data cannot end the script around it, whatever a row is called; the page's policy lets only `script` run
    data = json.dumps({table.key: table.plain() for table in tables}, separators=(",", ":"), allow_nan=False)
    data = data.replace("&", "\\u0026").replace("<", "\\u003c").replace(">", "\\u003e")
    script_hash = "sha256-" + base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    return render(
        "leaderboard.html.j2",
        headline=headline(headlined[0] if headlined else None),
        residuals=residual_sentence(first),
        margins=margins_sentence(first),
        table=tables[0],
        glance=glance(first),
        overview_circles=f"{group_title(first.group)}, {SELECTION_TITLES[first.selection]}",
        every_column=every_column(),
        cards=_cards(rows, every, paths),
        groups=[(group, group_title(group)) for group in dict.fromkeys(each.group for each in every)],
        selections=[(name, SELECTION_TITLES[name]) for name in dict.fromkeys(each.selection for each in every)],
        tracks=sorted({line.control for table in tables for line in table.lines}),
        channels=sorted({line.channel for table in tables for line in table.lines}),
        knowledge=sorted({line.track for table in tables for line in table.lines}),
        where="; ".join(sorted({path.where for own in paths.values() for path in own.values() if path.where})),
        agent_pages=agent_pages,
        adaptation=adaptation,
        style=resource("leaderboard.css"),
        script=script,
        script_hash=script_hash,
        data=data,
        provenance=provenance_lines(provenance),
        **{each.__name__: each for each in (length_with_change, count, digits, duration, group_title, share)},
    )


def all_standings(rows: Sequence[Row]) -> list[Standings]:
    """Compute standings on every group of plants and selection of circles that the zero action was run on."""
    found = [
        standings(rows, group, selection)
        for row in rows
        if row.name == UNCOMPENSATED
        for group in groups_of(row)
        for selection in SELECTIONS
        if collect_grid(row, group, SELECTIONS[selection]).cells
    ]
    return found or [standings(rows, GROUPS[0], next(iter(SELECTIONS)))]  # which names the missing rows


def _cards(rows: Sequence[Row], every: Sequence[Standings], paths: ToolTraces) -> list[Card]:
    """Make a card per row: those of the first standings on held-out circles in their order, then the others by name."""
    # standings of each group on the most circles, as selections are in order of importance
    held_out: dict[str, Standings] = {}
    for each in every:
        if set(SELECTIONS[each.selection]) <= set(HELD_OUT):
            held_out.setdefault(each.group, each)
    first = [line.row.name for each in list(held_out.values())[:1] for line in each.lines]
    order = {name: place for place, name in enumerate(first)}
    cards: list[Card] = []
    for row in sorted(rows, key=lambda row: (order.get(row.name, len(order)), row.name)):
        places = [(group, line) for group, each in held_out.items() if (line := each.line(row.name)) is not None]
        pictures = tool_pictures(paths.get(row.name, {}), paths.get(UNCOMPENSATED, {}))
        cards.append((row, places, learning_curve(row.learning_curve), pictures))
    return cards
