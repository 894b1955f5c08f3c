"""Recordings as CSV: the header as JSON in leading comment lines, a row of column names, one row per sample.

Numbers are written with the fewest digits that give back the same float, so that a round trip keeps every bit.
"""

import csv
from array import array

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.files import csv_rows
from ffgym.core.types import Array
from ffgym.recordings.header import Header
from ffgym.recordings.recording import Recording

MAGIC = "# ffgym recording"
"""First line of every file that `encode` writes."""


def encode(recording: Recording) -> bytes:
    """Return the bytes of a CSV file: UTF-8, lines end with a line feed."""
    lines = [MAGIC]
    lines += [f"# {line}" for line in recording.header.to_json(indent=1).split("\n")]
    lines.append(",".join(recording.columns))
    rows = csv_rows(np.stack(list(recording.columns.values()), axis=1))
    return ("\n".join(lines) + "\n" + rows).encode()


def decode(data: bytes, header: Header | None = None) -> Recording:
    """Return the recording in the bytes of a CSV file; a byte order mark and any line ends are accepted.

    A `header` replaces that of the file, or makes up for its lack in a file from another tool. Errors name the line,
    counted from 1.
    """
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise FFGymError(f"The CSV file is not UTF-8 text: byte {error.start} is {data[error.start]:#04x}.") from error
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    n_comments = next((i for i, line in enumerate(lines) if line.strip() and not line.startswith("#")), len(lines))
    own = lines[0].rstrip() == MAGIC
    if header is None:
        if not own:
            raise FFGymError(Header.how_to_pass(f"This CSV file does not begin with {MAGIC!r}"))
        header = Header.from_json("\n".join(line[1:] for line in lines[1:n_comments]))
    if own and lines[-1]:
        raise FFGymError(
            f"Line {len(lines)} has no line end: the file is cut short. Copy it again, or remove that line."
        )
    names, values = read_table(lines, n_comments)
    return Recording({name: values[:, i] for i, name in enumerate(names)}, header)


def read_table(lines: list[str], first: int) -> tuple[list[str], Array]:
    """Read column names and numbers, shape (T, columns), from line index `first` on; blank lines are skipped.

    Errors name the line, counted from 1.
    """
    reader = csv.reader((line + "\n" for line in lines[first:]), strict=True)
    names: list[str] = []
    values = array("d")
    try:
        for row in reader:
            if not row:
                continue
            line = first + reader.line_num
            # first row that is not blank: column names
            if not names:
                names = [name.strip() for name in row]
                if len(names) == 1 and any(separator in names[0] for separator in ";\t"):
                    raise FFGymError(
                        f"Line {line}: columns are separated by semicolons or tabs, must be by commas. Convert the "
                        "file."
                    )
                if twice := sorted({name for name in names if names.count(name) > 1}):
                    raise FFGymError(
                        f"Line {line} names {', '.join(map(repr, twice))} more than once. Rename or drop the copies."
                    )
            # further rows: one number per column
            elif len(row) != len(names):
                raise FFGymError(f"Line {line} has {len(row)} cells, must have {len(names)}, one per column.")
            else:
                _append(values, row, names, line)
    except csv.Error as error:
        raise FFGymError(f"Line {first + reader.line_num} is not CSV: {error}.") from error
    if not names:
        raise FFGymError("The CSV file has no row of column names.")
    return names, np.array(values, dtype=np.float64).reshape(-1, len(names))


def _append(values: array, row: list[str], names: list[str], line: int) -> None:
    try:
        if "_" in "".join(row):  # float() would skip it
            raise ValueError
        values.extend(map(float, row))
    except ValueError as error:
        name, cell = next((name, cell) for name, cell in zip(names, row, strict=True) if not _is_number(cell))
        cell = cell if len(cell) <= 40 else cell[:37] + "..."
        raise FFGymError(
            f"Line {line}, column {name!r}: {cell!r} is not a number. Write nan for a missing sample."
        ) from error


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return "_" not in cell
