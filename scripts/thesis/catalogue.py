"""Figures and tables of the thesis as items of the reproduction, made from the table `claims.toml`."""

import tomllib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from ffgym.core.errors import FFGymError
from ffgym.report import ReportFigure, SpeedTable, Table
from scripts.thesis import claims, pictures, tables
from scripts.thesis.claims import EVERY, THRESHOLDS, Claim
from scripts.thesis.comparisons import Cells, call, compare
from scripts.thesis.laboratory import Laboratory
from scripts.thesis.measures import AsPublished

FILE = Path(__file__).parent / "claims.toml"


@dataclass(frozen=True, kw_only=True, eq=False)
class Item:
    """One figure or table of the thesis, simulated."""

    name: str
    """Unique, e.g. 'figure-4.6'; also the name of its picture files."""
    chapter: str
    """'chapter-4', 'chapter-5', 'chapter-6' or 'beyond'."""
    title: str
    """What it shows; the heading names figure or table beside it."""
    claims: tuple[Claim, ...] = ()
    figures: Callable[[Laboratory], Sequence[ReportFigure]] = lambda laboratory: ()
    tables: Callable[[Laboratory], Sequence[SpeedTable]] = lambda laboratory: ()
    """Path errors, simulated beside published."""
    numbers: Callable[[Laboratory], Sequence[Table]] = lambda laboratory: ()
    """Other tables."""
    counterpart: str = ""
    """For figures of the real robot: which simulated item stands for it."""

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

    def checks(laboratory: Laboratory) -> list[claims.Check]:
        return compare(row, cells, TABLE, laboratory)

    return Claim(
        name=name,
        statement=statement.format(**THRESHOLDS),
        criterion=criterion.format(**THRESHOLDS),
        checks=checks,
        share={"EVERY": EVERY, "MOST": claims.MOST, "MAJORITY": claims.MAJORITY}[share],
        published=(lambda laboratory: checks(AsPublished(laboratory))) if published else lambda laboratory: (),  # type: ignore[arg-type]
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
        numbers=lambda laboratory: [table(laboratory) for table in numbers],
        **row,
        **shown,
    )


TABLE: dict[str, Any] = tomllib.loads(FILE.read_text(encoding="utf-8"))
ITEMS = tuple(_item(row) for row in TABLE["item"])
"""Every figure and table of chapters 4 to 6 that has numbers or curves; 4.1, 5.1, 5.4, 6.8 and 6.9 are diagrams. More
items go beyond it."""
