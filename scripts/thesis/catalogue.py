"""Figures and tables of the thesis as items, made from `claims.toml`; reproduced, as data and as one HTML page."""

import tomllib
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

from ffgym.core.errors import FFGymError
from ffgym.report import ReportFigure, SpeedTable, Table
from ffgym.report.circles.comparison import speed_table
from ffgym.report.page import provenance_lines, render, verdict_cell
from ffgym.robot import ModelOptions, compile_model, physics_fingerprint
from scripts.thesis import pictures, tables
from scripts.thesis.claims import (
    EVERY,
    MAJORITY,
    MOST,
    PARTLY,
    THRESHOLDS,
    VERDICTS,
    Cells,
    Check,
    Claim,
    Judgement,
    Verdict,
    call,
    compare,
    judge,
)
from scripts.thesis.measures import AsPublished
from scripts.thesis.studies import WORKCELL, ThesisStudies

FILE = Path(__file__).parent / "claims.toml"


@dataclass(frozen=True, kw_only=True, eq=False)
class Item:
    """One figure or table of the thesis, simulated."""

    name: str
    """Unique, e.g. 'figure-4.6'; also the name of its picture files."""
    chapter: str
    """'chapter-3', 'chapter-4', 'chapter-5', 'chapter-6' or 'beyond'."""
    title: str
    """Subject; the heading names figure or table beside it."""
    claims: tuple[Claim, ...] = ()
    figures: Callable[[ThesisStudies], Sequence[ReportFigure]] = lambda studies: ()
    tables: Callable[[ThesisStudies], Sequence[SpeedTable]] = lambda studies: ()
    """Path errors, simulated beside published."""
    numbers: Callable[[ThesisStudies], Sequence[Table]] = lambda studies: ()
    """Other tables."""
    counterpart: str = ""
    """Simulated item that stands for a figure of the real robot."""

    @property
    def heading(self) -> str:
        """E.g. 'Figure 4.6'."""
        return self.name.replace("-", " ").capitalize()


def chosen(items: Sequence[Item], only: Sequence[str]) -> list[Item]:
    """Items of the given names or chapters, in the order of the thesis; no name takes all.

    Raises:
        FFGymError: if there is no such item or chapter.
    """
    chapters = list(dict.fromkeys(item.chapter for item in items))
    for name in only:
        if name not in chapters and name not in {item.name for item in items}:
            raise FFGymError(
                f"Unknown item {name!r}. Available: {', '.join(chapters)}, or one of "
                f"{', '.join(item.name for item in items)}."
            )
    return [item for item in items if not only or item.name in only or item.chapter in only]


def _claim(entry: Cells, cells: Cells) -> Claim:
    row = dict(entry)
    name, statement, criterion = (row.pop(key) for key in ("name", "statement", "criterion"))
    share, published = row.pop("share", "EVERY"), row.pop("published", False)

    def checks(studies: ThesisStudies, *, fitted: bool = False) -> list[Check]:
        return compare(row, cells, TABLE, studies, fitted=fitted)

    return Claim(
        name=name,
        statement=statement.format(**THRESHOLDS),
        criterion=criterion.format(**THRESHOLDS),
        checks=checks,
        share={"EVERY": EVERY, "MOST": MOST, "MAJORITY": MAJORITY}[share],
        published=(lambda studies: checks(AsPublished(studies))) if published else lambda studies: (),  # type: ignore[arg-type]
        fitted=partial(checks, fitted=True),
    )


def _item(entry: Cells) -> Item:
    row = dict(entry)
    cells = row.pop("with", {})
    numbers = [partial(call, getattr(tables, name), cells=cells) for name in row.pop("numbers", ())]
    shown: dict[str, Any] = {
        kind: partial(call, getattr(module, row.pop(kind)), cells={**cells, "name": row["name"]})
        for kind, module in (("figures", pictures), ("tables", tables))
        if kind in row
    }
    return Item(
        claims=tuple(_claim(claim, cells) for claim in row.pop("claim", ())),
        numbers=lambda studies: [table(studies) for table in numbers],
        **row,
        **shown,
    )


TABLE: dict[str, Any] = tomllib.loads(FILE.read_text(encoding="utf-8"))
ITEMS = tuple(_item(row) for row in TABLE["item"])
"""Figure 3.3, and every figure and table of chapters 4 to 6 that has numbers or curves; 4.1, 5.1, 5.4, 6.8 and 6.9 are
diagrams. More items go beyond it."""


TITLES = {
    "chapter-3": "Chapter 3: B-splines",
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


def reproduce(items: Sequence[Item], studies: ThesisStudies) -> Iterator[Reproduced]:
    """Simulate what each item needs, draw it, and judge its claims; one item after the other."""
    for item in items:
        yield Reproduced(
            item=item,
            judgements=tuple(judge(claim, studies) for claim in item.claims),
            figures=tuple(item.figures(studies)),
            tables=tuple(item.tables(studies)),
            numbers=tuple(item.numbers(studies)),
        )


def count(results: Sequence[Reproduced]) -> dict[Verdict, int]:
    """Count the claims with each verdict; verdicts that none has are left out."""
    found = Counter(judgement.verdict for result in results for judgement in result.judgements)
    return {verdict: found[verdict] for verdict in VERDICTS if found[verdict]}


def fingerprints(studies: ThesisStudies) -> dict[str, str]:
    """Physics fingerprint of each robot and of the workcell, by name."""
    robots = (studies.robot, studies.axis)
    found = {robot.name: physics_fingerprint(compile_model(robot, ModelOptions(looks=False))) for robot in robots}
    return found | {WORKCELL: studies.workcell.fingerprint}


def as_json(results: Sequence[Reproduced], info: Mapping[str, Any]) -> dict[str, Any]:
    """Everything that was found, as JSON can hold it, with its origin `info`."""
    items = [
        {
            "name": result.item.name,
            "chapter": result.item.chapter,
            "title": result.item.title,
            "counterpart": result.item.counterpart,
            "claims": [_plain(judgement) for judgement in result.judgements],
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


def _plain(judgement: Judgement) -> dict[str, Any]:
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
        "fitted": plain(judgement.fitted),
    }
