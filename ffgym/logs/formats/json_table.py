"""JSON logs: an object of lists, a list of objects, either within objects, or one object per line."""

import json
from collections.abc import Iterator
from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ffgym.core.errors import FFGymError
from ffgym.logs.contents import NUMBERS, Contents
from ffgym.logs.log_format import LogFormat


class Json(LogFormat):
    """Arrays by key: `q`, or `arm.q` in objects within objects; of rows that are objects, a column per key."""

    title = "a JSON file"
    suffixes = (".json", ".jsonl")

    def decode(self, data: bytes, where: str) -> Contents:
        """Read a JSON table: columns, or rows with the same keys."""
        arrays: dict[str, NDArray[Any]] = {}
        skipped: dict[str, str] = {}
        for name, value in _leaves("", _tree(data)):
            with suppress(ValueError, OverflowError):
                arrays[name] = np.array(_with_nan(value))
            if name not in arrays or arrays[name].dtype.kind not in NUMBERS + "U":
                arrays.pop(name, None)
                skipped[name] = "a list of rows of different kinds or lengths"
        return Contents(where=where, arrays=arrays, skipped=skipped)


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


def _with_nan(value: Any) -> Any:
    """Numbers or text with NaN for null."""
    if isinstance(value, list):
        return [_with_nan(entry) for entry in value]
    return np.nan if value is None else value
