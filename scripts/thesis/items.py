"""Figures and tables of the thesis as items of the reproduction, and how they are chosen."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ffgym.core.errors import FFGymError
from ffgym.report import ReportFigure, SpeedTable
from scripts.thesis.claims import Claim
from scripts.thesis.laboratory import Laboratory


@dataclass(frozen=True, kw_only=True)
class PlainTable:
    """A table of texts; the first column stands on the left."""

    headings: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = ""
    """What the columns mean."""


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
    numbers: Callable[[Laboratory], Sequence[PlainTable]] = lambda laboratory: ()
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
