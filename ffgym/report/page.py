"""Pages of reports: single HTML files that load no other. This is the one door to jinja2."""

import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import cache
from importlib import resources
from itertools import count
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from ffgym.core.errors import FFGymError
from ffgym.report.figure import ReportFigure, require_matplotlib
from ffgym.report.table import Cell, Table

if TYPE_CHECKING:
    from jinja2 import Environment
    from markupsafe import Markup


@dataclass(frozen=True)
class Note:
    """A paragraph in small pale letters."""

    text: str


@dataclass(frozen=True)
class Legend:
    """A paragraph with the colours of pictures and tables."""

    text: str
    colours: Mapping[str, str]
    """Colours by the name of what is drawn in them."""


@dataclass(frozen=True)
class Code:
    """Lines of a program or a file."""

    text: str


@dataclass(frozen=True)
class Items:
    """A list with bullets."""

    entries: Sequence[str]


@dataclass(frozen=True)
class Details:
    """Parts that a page hides until a reader opens them."""

    summary: str
    parts: "Sequence[Part]"


@dataclass(frozen=True)
class Section:
    """A heading with the parts below it."""

    title: str
    parts: "Sequence[Part]"
    headline: Sequence[str] = ()
    """Paragraphs in a box below the heading."""
    is_boxed: bool = False
    """True for a frame around all of it."""


Part = str | Note | Legend | Code | Items | Details | Section | Table | ReportFigure
"""Part of a page; a text is a paragraph, in which `code` and **bold** are set as in Markdown. A section in a section
has a smaller heading."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Page:
    """A page that can be sent."""

    title: str
    subtitle: str = ""
    reading: "Sequence[Part]" = ()
    """Guide to reading the page, which comes first."""
    headline: Sequence[str] = ()
    """Main results, a paragraph each."""
    parts: Sequence[Part] = ()
    provenance: Mapping[str, Any]
    """Origin of the numbers by name; a dict in it gives a line per entry."""
    is_dated: bool = True
    """True for the time of writing on the page; without, the same parts give the same bytes."""

    def html(self) -> str:
        """Render the page as HTML; figures are numbered in its order.

        Raises:
            FFGymError: if matplotlib or jinja2 is missing.
        """
        written = {"written": now()} if self.is_dated else {}
        return render("page.html.j2", page=self, provenance=provenance_lines(self.provenance) | written)


def render(name: str, **context: Any) -> str:
    """Render the template of that name, for pages that need more than `Page` has."""
    require_matplotlib()
    return _environment().get_template(name).render(next_number=count(1).__next__, **context)


def now() -> str:
    """Return the time at which a page is written."""
    return datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")


def provenance_lines(info: Mapping[str, Any]) -> dict[str, str]:
    """Convert names and values to text; entries of a dict become lines, entries of a list share one.

    The name of a command gives way to the line that runs it, which says too what options are not given.
    """
    lines: dict[str, str] = {}
    if "command_line" in info:
        given = {name: value for name, value in info["config"].items() if value not in (None, (), [], False)}
        info = {name: value for name, value in info.items() if name != "command"} | {"config": given}
    for name, value in info.items():
        if isinstance(value, Mapping):
            lines |= provenance_lines(value)
        elif isinstance(value, list | tuple):
            separator = "\n" if name == "inputs" else ", "  # a line for each input file
            lines[name.replace("_", " ")] = separator.join(str(entry) for entry in value) or "none"
        else:
            lines[name.replace("_", " ")] = "none" if value is None else str(value)
    return lines


def verdict_cell(word: str) -> Cell:
    """Make the cell of a verdict with its sign: full, half or empty."""
    signs = {"reproduced": "good", "holds": "good", "partly reproduced": "partly", "partly": "partly"}
    signs |= {"not reproduced": "bad", "does not hold": "bad"}
    return Cell(word, style=f"verdict {signs.get(word, 'none')}")


@cache
def words_of(page: str) -> Mapping[str, str]:
    """Read the texts of a page from words.toml."""
    texts: dict[str, str] = tomllib.loads(resource("words.toml"))[page]
    return MappingProxyType(texts)


def resource(name: str) -> str:
    """Read a text file beside the templates."""
    return (resources.files("ffgym.report") / "templates" / name).read_text(encoding="utf-8")


def _environment() -> "Environment":
    try:
        from jinja2 import Environment, FunctionLoader, StrictUndefined
    except ImportError as error:
        raise FFGymError("The report page needs jinja2; pip install 'ffgym[report]'.") from error
    environment = Environment(
        loader=FunctionLoader(resource),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["kind"] = lambda part: type(part).__name__
    environment.filters["prose"] = _prose
    return environment


def _prose(text: str) -> "Markup":
    """Escape a text, and set `code` and **bold** in it."""
    from markupsafe import Markup, escape

    marked = re.sub(r"`([^`]+)`", r"<code>\1</code>", str(escape(text)))
    return Markup(re.sub(r"\*\*(.+?)\*\*", r"<b>\1</b>", marked))
