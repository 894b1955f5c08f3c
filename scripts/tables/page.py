"""A documentation page with parts that are made: each stands between `<!-- name -->` and `<!-- end -->`."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ffgym.core.errors import FFGymError
from ffgym.core.files import read_text, write_text
from ffgym.report import Table, save_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DOCS = Path(__file__).parents[2] / "docs"
WHOLE = ""
"""Name of a part that is the whole page."""
DPI = 100
"""Pixels per inch of pictures."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Contents:
    """The made parts of a page."""

    parts: Mapping[str, str] = field(default_factory=dict)
    """Markdown by name."""
    numbers: Mapping[str, Any] = field(default_factory=dict)
    """Numbers behind them as JSON can hold them."""
    pictures: Mapping[str, "Figure"] = field(default_factory=dict)
    """Pictures by name of the file without its ending."""

    def write(self, page: Path) -> None:
        """Renew the parts of a page, and the pictures that it shows from its folder pictures/."""
        text = read_text(page) if WHOLE not in self.parts else ""
        if self.parts:
            write_text(page, renew(text, self.parts))
        for name, figure in self.pictures.items():
            if f"(pictures/{name}.png)" in text:
                save_figure(figure, page.parent / "pictures" / f"{name}.png", DPI)


def renew(text: str, parts: Mapping[str, str]) -> str:
    """Text of a page with its parts replaced.

    Raises:
        FFGymError: if it has no place for one.
    """
    for name, part in parts.items():
        if name == WHOLE:
            text = part
            continue
        before, mark, rest = text.partition(f"<!-- {name} -->\n")
        _, end, after = rest.partition("<!-- end -->")
        if not mark or not end:
            raise FFGymError(f"The page lacks the marks '<!-- {name} -->' and '<!-- end -->' around part {name!r}.")
        text = f"{before}{mark}{part}\n{end}{after}"
    return text


def rows_of(page: Path, part: str) -> list[list[str]]:
    """Read the cells of the rows of a made table from a page, without its head."""
    _, _, rest = read_text(page).partition(f"<!-- {part} -->\n")
    table, _, _ = rest.partition("<!-- end -->")
    lines = [line for line in table.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[2:]]


def markdown(head: Sequence[str], rows: Iterable[Sequence[str]], *, aligned: bool = False) -> str:
    """Format a Markdown table of texts; `aligned` for terminals."""
    return Table.of_rows(head, list(rows)).markdown(aligned=aligned)
