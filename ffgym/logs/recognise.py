"""Built-in column maps that a file fits, by the names of its arrays."""

import re

from ffgym.logs.column_map import Column, ColumnMap, builtin_columns, load_columns
from ffgym.logs.contents import Contents
from ffgym.logs.gather import PLACE

_ANY = {"joint": ".+", "number": r"\d+", "index": r"\d+"}
"""What may stand in a place of a name, as long as it is not known whose log it is."""


def fitting_maps(contents: Contents) -> list[str]:
    """Names of built-in column maps all of whose entries that are not optional the file has arrays for."""
    return [name for name in builtin_columns() if _fits(load_columns(name), contents)]


def _fits(columns: ColumnMap, contents: Contents) -> bool:
    return all(column.optional or _held(column, contents) for column in columns.columns.values())


def _held(column: Column, contents: Contents) -> bool:
    """Whether the file has arrays for an entry, of one joint at least."""
    if isinstance(column.rate_hz, str):
        return column.rate_hz in contents.arrays
    if isinstance(column.source, tuple):
        return set(column.source) <= set(contents.arrays)
    return not column.source or any(_has(name, contents) for name in (column.source, *column.otherwise))


def _has(name: str, contents: Contents) -> bool:
    parts = [_ANY[part] if k % 3 == 1 else re.escape(part) for k, part in enumerate(PLACE.split(name)) if k % 3 != 2]
    pattern = re.compile("".join(parts))
    return any(pattern.fullmatch(array) for array in contents.arrays)
