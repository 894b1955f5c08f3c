"""What was reproduced: every item with its pictures, tables and verdicts, as data and as one HTML page."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from ffgym.report import ReportFigure, SpeedTable, Table
from ffgym.report.circles.comparison import speed_table
from ffgym.report.page import provenance_lines, render, verdict_cell
from ffgym.robot import ModelOptions, compile_model, physics_fingerprint
from scripts.thesis.catalogue import Item
from scripts.thesis.claims import EVERY, MAJORITY, MOST, PARTLY, VERDICTS, Check, Judgement, Verdict, judge
from scripts.thesis.laboratory import WORKCELL, Laboratory

TITLES = {
    "chapter-4": "Chapter 4: feed-forward with the LuGre model",
    "chapter-5": "Chapter 5: feed-forward learned with B-spline networks",
    "chapter-6": "Chapter 6: extended friction identification",
    "beyond": "Beyond the thesis",
}
"""Headings of the parts."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Reproduced:
    """One item, simulated and judged."""

    item: Item
    judgements: tuple[Judgement, ...]
    figures: tuple[ReportFigure, ...]
    tables: tuple[SpeedTable, ...]
    numbers: tuple[Table, ...]


def reproduce(items: Sequence[Item], laboratory: Laboratory) -> Iterator[Reproduced]:
    """Simulate what each item needs, draw it, and judge its claims; one item after the other."""
    for item in items:
        yield Reproduced(
            item=item,
            judgements=tuple(judge(claim, laboratory) for claim in item.claims),
            figures=tuple(item.figures(laboratory)),
            tables=tuple(item.tables(laboratory)),
            numbers=tuple(item.numbers(laboratory)),
        )


def count(results: Sequence[Reproduced]) -> dict[Verdict, int]:
    """How many claims have each verdict; verdicts that none has are left out."""
    found = Counter(judgement.verdict for result in results for judgement in result.judgements)
    return {verdict: found[verdict] for verdict in VERDICTS if found[verdict]}


def fingerprints(laboratory: Laboratory) -> dict[str, str]:
    """Physics fingerprint of each robot and of the workcell, by name."""
    robots = (laboratory.robot, laboratory.axis)
    found = {robot.name: physics_fingerprint(compile_model(robot, ModelOptions(looks=False))) for robot in robots}
    return found | {WORKCELL: laboratory.workcell.fingerprint}


def as_json(results: Sequence[Reproduced], info: Mapping[str, Any]) -> dict[str, Any]:
    """Everything that was found, as JSON can hold it, with its origin `info`."""
    items = [
        {
            "name": result.item.name,
            "chapter": result.item.chapter,
            "title": result.item.title,
            "counterpart": result.item.counterpart,
            "claims": [_claim(judgement) for judgement in result.judgements],
            "figures": {figure.name: figure.caption for figure in result.figures},
            "tables": [asdict(table) for table in result.tables],
            "numbers": [table.plain() for table in result.numbers],
        }
        for result in results
    ]
    return {**info, "verdicts": count(results), "items": items}


def render_page(results: Sequence[Reproduced], info: Mapping[str, Any]) -> str:
    """HTML of the reproduction, one page that needs nothing else.

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
        chapters={TITLES[chapter]: [one for one in results if one.item.chapter == chapter] for chapter in chapters},
        circles=lambda table: speed_table(table, with_ratio=False),
        verdict_cell=verdict_cell,
        shares={"every": EVERY, "most": MOST, "majority": MAJORITY, "partly": PARTLY},
        provenance=provenance_lines(info),
    )


def _claim(judgement: Judgement) -> dict[str, Any]:
    def plain(checks: Sequence[Check]) -> list[dict[str, Any]]:
        return [asdict(check) | {"true": bool(check.true)} for check in checks]

    return {
        "name": judgement.claim.name,
        "statement": judgement.claim.statement,
        "criterion": judgement.claim.criterion,
        "share": judgement.claim.share,
        "verdict": judgement.verdict,
        "checks": plain(judgement.checks),
        "published": plain(judgement.published),
    }
