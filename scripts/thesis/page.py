"""The reproduction as one HTML page that needs nothing else, in the style of the demo's report."""

from collections.abc import Mapping, Sequence
from typing import Any

from ffgym.report import law_styles
from ffgym.report.html import embedded, provenance_lines, render
from scripts.thesis.claims import EVERY, MAJORITY, MOST, PARTLY
from scripts.thesis.reproduce import Reproduced, count

TITLES = {
    "chapter-4": "Chapter 4: feed-forward with the LuGre model",
    "chapter-5": "Chapter 5: feed-forward learned with B-spline networks",
    "chapter-6": "Chapter 6: extended friction identification",
    "beyond": "Beyond the thesis",
}
"""Headings of the parts."""


def render_page(results: Sequence[Reproduced], info: Mapping[str, Any]) -> str:
    """HTML of the reproduction.

    Args:
        results: items in the order of the page.
        info: provenance by name, e.g. seed and command; a dict in it gives a line per entry.

    Raises:
        FFGymError: if matplotlib or jinja2 is missing.
    """
    chapters = dict.fromkeys(result.item.chapter for result in results)
    return render(
        "reproduction.html.j2",
        counts=count(results),
        results=results,
        chapters={
            TITLES[chapter]: [_shown(result) for result in results if result.item.chapter == chapter]
            for chapter in chapters
        },
        styles=law_styles([agent for result in results for table in result.tables for agent in table.agents]),
        shares={"every": EVERY, "most": MOST, "majority": MAJORITY, "partly": PARTLY},
        provenance=provenance_lines(info),
    )


def _shown(result: Reproduced) -> dict[str, Any]:
    return {
        "item": result.item,
        "judgements": result.judgements,
        "tables": result.tables,
        "numbers": result.numbers,
        "figures": [embedded(figure) for figure in result.figures],
    }
