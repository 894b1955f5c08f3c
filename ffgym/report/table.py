"""Tables of reports: the same rows as text for a terminal, as Markdown, and as HTML of a page."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from textwrap import wrap
from typing import Any, Literal

WIDTH = 120
"""Columns of a terminal that every line fits in."""

Kind = Literal["number", "text", "name", "code", "prose"]
"""Alignment of a column: numbers stand on the right of a page, all others on the left. A terminal cuts names, which
come from files, at 30 letters; prose wraps on a page."""

_CLASSES = {"number": "", "text": "l", "name": "l", "code": "l", "prose": "wrap"}


@dataclass(frozen=True)
class Cell:
    """A text with a pale detail behind it."""

    text: str
    detail: str = ""
    style: str = ""
    """CSS classes on a page."""
    colour: str = ""
    """Colour of a swatch before the text on a page."""

    @property
    def plain(self) -> str:
        """Text and detail in one line."""
        return f"{self.text} {self.detail}".strip()


def pair(value: float | None, detail: float | None, form: str, form_of_detail: str = "") -> Cell | None:
    """Format a number with another one in brackets, e.g. an RMS and a maximum; None without the first one."""
    if value is None:
        return None
    behind = "-" if detail is None else format(detail, form_of_detail or form)
    return Cell(format(value, form), f"({behind})")


@dataclass(frozen=True)
class Column:
    """A heading and a value for each row."""

    heading: str
    values: Sequence[Any]
    """Numbers, texts or cells; None for an empty cell."""
    form: str = ""
    """Format of numbers, e.g. '.3f'."""
    unit: str = ""
    """Unit of all numbers, which stands behind the heading."""
    kind: Kind = "number"
    group: str = ""
    """Heading above this column and its neighbours of the same group."""
    colour: str = ""
    """Colour of a swatch before the heading of the group, or before the own one, on a page."""
    style: str = ""
    """CSS classes of the cells on a page."""

    @property
    def title(self) -> str:
        """Heading with the unit."""
        return f"{self.heading} [{self.unit}]" if self.unit else self.heading

    @property
    def css(self) -> str:
        """Classes that all cells and the heading have on a page."""
        return _CLASSES[self.kind]

    def cells(self, nothing: str = "-") -> list[Cell]:
        """Make a cell for each row, with the text `nothing` for None."""
        return [self._cell(value, nothing) for value in self.values]

    def _cell(self, value: Any, nothing: str) -> Cell:
        if isinstance(value, Cell):
            return value
        if value is None:
            return Cell(nothing)
        return Cell(value if isinstance(value, str) else format(value, self.form))


@dataclass(frozen=True, kw_only=True)
class Table:
    """Columns of equal length with title and note."""

    columns: Sequence[Column]
    name: str = ""
    """Name in links and scripts."""
    title: str = ""
    note: str = ""
    """Explanation of the columns."""
    fixed: int = 1
    """Number of columns on the left that are repeated if a terminal is too narrow for all."""
    ruled_by: int | None = None
    """Column whose changes a page marks with a line."""
    strong: Sequence[int] = ()
    """Rows that a page emphasises, e.g. means; -1 is the last one."""

    @classmethod
    def of_rows(cls, headings: Sequence[str], rows: Sequence[Sequence[Any]], **options: Any) -> "Table":
        """Make a table of texts that come row by row."""
        kinds: Kind = "text"
        columns = [Column(heading, [row[k] for row in rows], kind=kinds) for k, heading in enumerate(headings)]
        return cls(columns=columns, **options)

    @property
    def n_rows(self) -> int:
        """Number of rows below the heading."""
        return len(self.columns[0].values) if self.columns else 0

    @property
    def groups(self) -> list[tuple[str, list[Column]]]:
        """Neighbouring columns by the heading they share; without one each stands alone."""
        grouped = groupby(enumerate(self.columns), key=lambda entry: entry[1].group or entry[0])
        return [(key if isinstance(key, str) else "", [column for _, column in own]) for key, own in grouped]

    @property
    def headings(self) -> tuple[str, ...]:
        """Headings with units."""
        return tuple(column.title for column in self.columns)

    @property
    def rows(self) -> tuple[tuple[str, ...], ...]:
        """Texts of each row."""
        return tuple(zip(*([cell.plain for cell in column.cells()] for column in self.columns), strict=True))

    @property
    def page_rows(self) -> list[tuple[str, list[tuple[str, Cell]]]]:
        """Rows of a page: CSS classes of the row, and cells with theirs."""
        columns = [column.cells("–") for column in self.columns]
        edges = {id(own[0]) for title, own in self.groups if title}
        css = [" ".join(filter(None, (c.css, "edge" * (id(c) in edges), c.style))) for c in self.columns]
        strong = {k % self.n_rows for k in self.strong} if self.n_rows else set()
        rows = []
        for k, cells in enumerate(zip(*columns, strict=True)):
            changes = self.ruled_by is not None and cells[self.ruled_by] != columns[self.ruled_by][k - 1]
            classes = " ".join(["mean"] * (k in strong) + ["first"] * (changes or (k in strong and k > 0)))
            shown = [(f"{own} {cell.style}".strip(), cell) for own, cell in zip(css, cells, strict=True)]
            rows.append((classes, shown))
        return rows

    def plain(self) -> dict[str, Any]:
        """Return headings, rows of texts and note for JSON."""
        return {"headings": self.headings, "rows": self.rows, "note": self.note}

    def text(self) -> str:
        """Format the table for a terminal; columns that do not fit go below, with the fixed ones on their left."""
        left = _join(self.columns[: self.fixed])
        has_groups = any(title for title, _ in self.groups)
        left = [" " * len(left[0])] * has_groups + left
        tables: list[list[str]] = []
        # groups of columns side by side, until a line is full
        for title, columns in Table(columns=self.columns[self.fixed :]).groups:
            lines = [shorten(title)] * has_groups + _join(columns)
            width = max(len(line) for line in lines)
            between = " | " if title or not tables or len(tables[-1][0]) == len(left[0]) else "  "
            if not tables or len(tables[-1][0]) + len(between) + width > WIDTH:
                tables.append(left)
                between = " | "
            tables[-1] = [f"{row}{between}{line:<{width}}" for row, line in zip(tables[-1], lines, strict=True)]
        shown = [table[1:] if not table[0].strip(" |") else table for table in tables or [left]]  # no group, no line
        return "\n\n".join("\n".join(line.rstrip() for line in table) for table in shown)

    def markdown(self, *, aligned: bool = False) -> str:
        """Format the table in Markdown; `aligned` cells are as wide as their column, for terminals."""
        rows = [[text.replace("|", r"\|") for text in row] for row in (self.headings, *self.rows)]
        rule = "|---" * len(self.columns) + "|"
        if aligned:
            widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
            rows = [[text.ljust(width) for text, width in zip(row, widths, strict=True)] for row in rows]
            rule = f"| {' | '.join('-' * width for width in widths)} |"
        head, *lines = [f"| {' | '.join(row)} |" for row in rows]
        return "\n".join([head, rule, *lines])


def _join(columns: Sequence[Column]) -> list[str]:
    """Join columns side by side, as lines of equal length."""
    texts = [
        [column.title, *(shorten(c.plain) if column.kind == "name" else c.plain for c in column.cells())]
        for column in columns
    ]
    widths = [max(map(len, column)) for column in texts]
    return ["  ".join(f"{t:<{w}}" for t, w in zip(row, widths, strict=True)) for row in zip(*texts, strict=True)]


def shorten(name: str, room: int = 30) -> str:
    """Shorten a name, which may be long in a file, to the room of a line."""
    return name if len(name) <= room else name[: room - 1] + "…"


def wrap_text(text: str) -> str:
    """Wrap a text into lines that fit a terminal."""
    return "\n".join(wrap(text, WIDTH))


def underline(title: str) -> str:
    """Underline the title of a text for a terminal."""
    return f"{title}\n{'-' * min(len(title), WIDTH)}"
