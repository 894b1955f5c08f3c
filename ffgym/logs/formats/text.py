"""CSV, TSV and other tables in text: delimiters, decimal commas, lines before the table, a row of units."""

import csv
import gzip
import io
import re
import zlib
from array import array
from collections import Counter
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ffgym.core.errors import FFGymError
from ffgym.core.files import check_unpacked, most_unpacked, read_bytes
from ffgym.logs.contents import Contents
from ffgym.logs.log_format import PACKED, LogFormat
from ffgym.logs.text_layout import TextLayout

DELIMITERS = ("\t", ";", ",")
"""Tried in this order; a comma may also be a decimal one. Blank space comes last."""

_BLANK = " "

_MISSING = frozenset({"", "nan", "NaN", "NAN", "-nan", "#N/A", "N/A", "null", "None"})
"""Cells without a sample."""


class Text(LogFormat):
    """Columns of numbers by their titles, or of text where a cell is neither a number nor empty."""

    title = "a table in text"
    suffixes = (".csv", ".tsv", ".txt", ".dat", ".asc")
    is_text = True

    def recognises(self, path: Path) -> bool:
        """Tell whether a file is text by its ending; gzip may have packed it."""
        packed = path.suffix.lower() == PACKED
        return super().recognises(Path(path.stem) if packed and path.is_file() else path)

    def read(self, path: Path, layout: TextLayout) -> Contents:
        """Read a text file, unpacked if need be."""
        data = read_bytes(path)
        if path.suffix.lower() == PACKED:
            try:
                with gzip.open(io.BytesIO(data)) as packed:
                    text = packed.read(most_unpacked(len(data)) + 1)
            except (OSError, EOFError, zlib.error) as error:
                raise FFGymError(f"is no whole gzip file: {error}. Copy it again.") from error
            check_unpacked("The file", len(data), len(text))
            data = text
        return self.decode(data, str(path), layout)

    def decode(self, data: bytes, where: str, layout: TextLayout | None = None) -> Contents:
        """Read the columns of a text; `layout` says what cannot be seen."""
        layout = layout or TextLayout()
        try:
            text = data.decode(layout.encoding)
        except UnicodeError as error:
            raise FFGymError(
                f"The file is not {layout.encoding} text ({error}). encoding in [file] of the column map names "
                'another, e.g. "latin-1" or "utf-16".'
            ) from error
        lines = text.replace("\r\n", "\n").replace("\r", "\n").removesuffix("\n").split("\n")
        names_row = _names_row(lines, layout)
        _check_units_row(lines, names_row or 0, layout)
        first = layout.first_row or max(names_row or 0, layout.units_row or 0) + 1
        shown = "".join(lines[(names_row or first) - 1 : names_row or first])  # the line of names, or the first row
        tried = [delimiter for delimiter in DELIMITERS if delimiter != layout.decimal]
        delimiter = layout.delimiter or next((one for one in tried if one in shown), _BLANK)
        numbered = enumerate(lines[first - 1 :], start=first)
        kept = [(n, line) for n, line in numbered if line.strip() and not line.startswith(layout.comment)]
        rows = [(number, _split(line, delimiter, number)) for number, line in kept]
        if not rows:
            raise FFGymError(f"There are no rows from line {first} on.")
        if names_row:
            titles = _split(lines[names_row - 1], delimiter, names_row)
            if not any(titles):
                raise FFGymError(
                    f"Line {names_row} holds no names of columns; names_row in [file] says where they are."
                )
        else:
            titles = [str(i + 1) for i in range(len(rows[0][1]))]
        titles, table = _rectangular(titles, rows)
        names = _names(titles)
        cells = zip(names, zip(*table, strict=True), strict=True)
        return Contents(where=where, arrays={name: _column(column, layout.decimal) for name, column in cells})


def _names_row(lines: list[str], layout: TextLayout) -> int | None:
    """Line with the names, from 1; None if there is none."""
    if layout.names_row == 0:
        return None
    if layout.names_row is not None:
        if layout.names_row > len(lines):
            raise FFGymError(f"[file] names_row = {layout.names_row}, but the file has only {len(lines)} lines.")
        return layout.names_row
    start = _first_line(lines, 1, layout)
    if start is None:
        raise FFGymError("The file has no lines but blank ones and comments.")
    cells = re.split(r"[\t;\s]+" if layout.decimal == "," else r"[\t;,\s]+", lines[start - 1].strip())
    numbers = [_number(cell, layout.decimal) for cell in cells if cell]
    return None if numbers and None not in numbers else start


def _check_units_row(lines: list[str], names_row: int, layout: TextLayout) -> None:
    """Refuse a line of units that is not the one after the names: rows before it would be lost."""
    units_row = layout.units_row
    if units_row is None:
        return
    if units_row <= names_row or _first_line(lines[: units_row - 1], names_row + 1, layout) is not None:
        raise FFGymError(
            f"[file] units_row = {units_row} must be the line after the names, which are in line {names_row}; "
            "only blank lines and comments may come between. Leave it out if there are no units."
        )


def _first_line(lines: list[str], start: int, layout: TextLayout) -> int | None:
    """First line from `start` on, from 1, that is neither blank nor a comment."""
    for number, line in enumerate(lines[start - 1 :], start=start):
        if line.strip() and not line.startswith(layout.comment):
            return number
    return None


def _split(line: str, delimiter: str, number: int) -> list[str]:
    if delimiter == _BLANK:
        return line.split()
    if '"' not in line:
        return [cell.strip() for cell in line.split(delimiter)]
    try:
        return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter, strict=True))]
    except (csv.Error, StopIteration) as error:
        raise FFGymError(f"Line {number} is not a row of cells: {error}.") from error


def _names(titles: list[str]) -> list[str]:
    """Names of columns; the second `q` is called `q#2`, and the third column `#3` if it has none."""
    seen: Counter[str] = Counter()
    names = []
    for number, title in enumerate(titles, start=1):
        seen[title] += 1
        again = f"#{seen[title]}" if seen[title] > 1 else ""
        names.append(f"{title}{again}" if title else f"#{number}")
    return names


def _rectangular(names: list[str], rows: list[tuple[int, list[str]]]) -> tuple[list[str], list[list[str]]]:
    """Names and cells without the empty column that a delimiter at the end of each line makes."""
    if all(cells and cells[-1] == "" for _, cells in rows):
        unnamed = names[-1] == ""
        if unnamed or len(names) == len(rows[0][1]) - 1:
            rows = [(line, cells[:-1]) for line, cells in rows]
            names = names[:-1] if unnamed else names
    for line, cells in rows:
        if len(cells) != len(names):
            raise FFGymError(
                f"Line {line} has {len(cells)} cells, but there are {len(names)} columns: "
                f"{', '.join(names)[:80]}. "
                "Damaged or cut short there, or [file] must say what delimiter, decimal and names_row are."
            )
    return names, [cells for _, cells in rows]


def _column(cells: tuple[str, ...], decimal: str) -> NDArray[Any]:
    together = "".join(cells)
    if decimal == "." and "_" not in together:
        with suppress(ValueError):  # cells that are empty, or words, are looked at one by one below
            return np.array(array("d", map(float, cells)))
    numbers = [_number(cell, decimal) for cell in cells]
    if None not in numbers:
        return np.array(numbers, dtype=np.float64)
    words = []  # cells that are numbers get a decimal point, as a message says which are none
    for cell, number in zip(cells, numbers, strict=True):
        with_point = decimal == "," and _number(cell, ".") is not None
        words.append(repr(number) if number is not None else f"{cell} with a decimal point" if with_point else cell)
    return np.array(words)


def _number(cell: str, decimal: str) -> float | None:
    """Number in a cell, NaN for a missing one, None if it is something else."""
    if cell in _MISSING:
        return np.nan
    if "_" in cell or (decimal == "," and "." in cell):  # float skips the one; the other separates thousands
        return None
    try:
        return float(cell.replace(",", ".") if decimal == "," else cell)
    except ValueError:
        return None
