"""JSON logs: an object of lists, a list of objects, either within objects, or one object per line."""

import json
from collections.abc import Iterator
from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ffgym.core.errors import FFGymError
from ffgym.logs.contents import Contents
from ffgym.logs.log_format import LogFormat


class Json(LogFormat):
    """Arrays by key: `q`, or `arm.q` in objects within objects; of rows that are objects, a column per key."""

    title = "a JSON file"
    suffixes = (".json", ".jsonl")

    def decode(self, data: bytes, where: str) -> Contents:
        """See base class."""
        arrays = {name: _array(value) for name, value in _leaves("", _tree(data))}
        skipped = {n: "a list of rows of different kinds or lengths" for n, array in arrays.items() if array is None}
        return Contents(where=where, arrays={n: a for n, a in arrays.items() if a is not None}, skipped=skipped)


def _tree(data: bytes) -> Any:
    """The one value of the file, or a list with that of each line."""
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise FFGymError(f"it is no UTF-8 text: {error}.") from error
    try:
        return json.loads(text)
    except RecursionError as error:
        raise FFGymError("it holds lists in lists without end.") from error
    except ValueError as whole:
        lines = [line for line in text.splitlines() if line.strip()]
        with suppress(ValueError, RecursionError):
            if len(lines) > 1:
                return [json.loads(line) for line in lines]
        raise FFGymError(f"it is no valid JSON, nor one object per line: {whole}. Copy it again.") from whole


def _leaves(path: str, value: Any) -> Iterator[tuple[str, Any]]:
    """Lists and single values by path; rows that are objects become columns."""
    if isinstance(value, dict):
        for key, entry in value.items():
            yield from _leaves(f"{path}.{key}" if path else str(key), entry)
    elif isinstance(value, list) and value and all(isinstance(row, dict) for row in value):
        for key in dict.fromkeys(key for row in value for key in row):
            cells = [row.get(key) for row in value]
            if any(isinstance(cell, dict) for cell in cells):  # whose keys are columns themselves
                cells = [cell if isinstance(cell, dict) else {} for cell in cells]
            yield from _leaves(f"{path}.{key}" if path else key, cells)
    else:
        yield path or "values", value


def _array(value: Any) -> NDArray[Any] | None:
    """Numbers with NaN for null, or text; None if it is neither, or ragged."""
    cells = _with_nan(value)
    try:
        array = np.array(cells)
    except (ValueError, OverflowError):
        return None
    return array if array.dtype.kind in "biufU" else None


def _with_nan(value: Any) -> Any:
    if isinstance(value, list):
        return [_with_nan(entry) for entry in value]
    return np.nan if value is None else value
