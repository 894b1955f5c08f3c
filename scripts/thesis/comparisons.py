"""The engine of the claims' table: a row becomes comparisons of numbers that are measured in results."""

from collections.abc import Callable, Iterator, Mapping
from inspect import signature
from itertools import product
from typing import Any

import numpy as np

from ffgym.core.types import Array
from ffgym.report import law_styles
from scripts.thesis import measures
from scripts.thesis.claims import THRESHOLDS, Check
from scripts.thesis.laboratory import Laboratory

Cells = Mapping[str, Any]
"""Cells of the table by name, e.g. law, position and speed [m/s]; see `claims.toml`."""

RULES = ("kind", "each", "but", "checks", "where", "value", "limit")
"""Entries of a row that say how to compare; the others are cells."""


def compare(row: Cells, cells: Cells, table: Cells, laboratory: Laboratory) -> list[Check]:
    """Comparisons of a row of the table, in the order of its `each`.

    Args:
        row: the row, or one of its `checks`.
        cells: cells that it shares with others.
        table: the whole table, for its lists and kinds.
        laboratory: whose results are measured; what it does not have (None) is not compared.
    """
    kind = table["kind"].get(row.get("kind"), {})
    cells = {**_cells(kind), **cells, **_cells(row)}
    row = {**kind, **row}
    checks: list[Check] = []
    for combination in _combinations(row.get("each", {}), table["lists"]):
        here = {**cells, **combination}
        if "but" in row and row["but"].items() <= here.items():
            continue
        if "checks" in row:
            for part in row["checks"]:
                checks += compare(part, here, table, laboratory)
        else:
            value, limit = (number(row[side], here, laboratory) for side in ("value", "limit"))
            if value is not None and limit is not None:
                checks += _checks(text(row["where"], here), value, limit)
    return checks


def number(entry: Any, cells: Cells, laboratory: Laboratory) -> Any:
    """Number that an entry of the table stands for, or one per random start; None where nothing can be measured."""
    if isinstance(entry, str):
        first, _, second = entry.rpartition(" - ")
        return _named(first, cells) - _named(second, cells) if first else _named(second, cells)
    if not isinstance(entry, Mapping):
        return entry
    if "apart" in entry:
        one, other = (number(each, cells, laboratory) for each in entry["apart"])
        return abs(one - other)
    found = call(getattr(measures, entry["measure"]), laboratory, {**cells, **entry})
    return None if found is None else number(entry.get("times", 1.0), cells, laboratory) * found


def call(function: Callable[..., Any], laboratory: Laboratory, cells: Cells) -> Any:
    """Call a function of the laboratory with those of the cells that it asks for."""
    known = THRESHOLDS | measures.RECORDS | dict(cells)
    asked = {name: cells[name] for name in signature(function).parameters if name in cells}
    named = {name: known[value[1:]] for name, value in asked.items() if str(value).startswith("$")}
    return function(laboratory, **asked | named)


def text(template: str, cells: Cells) -> str:
    """Words of the table, with cells and thresholds in their places."""
    words = THRESHOLDS | dict(cells)
    if "law" in cells:
        words["law"] = law_styles([cells["law"]])[cells["law"]].label
    if "than" in cells and "law" in cells:
        by = number(cells.get("by", 0.0), cells, measures.NOTHING)
        than = law_styles([cells["than"]])[cells["than"]].label
        words["against"] = f"{words['law']} against {f'{1 - by:.0%} of ' if by else ''}{than}"
    if "speed" in cells:
        words["mm_s"] = cells["speed"] * 1e3
    return template.format(**words)


def _cells(row: Cells) -> Cells:
    return {name: value for name, value in row.items() if name not in RULES}


def _combinations(each: Cells, lists: Mapping[str, list[Any]]) -> Iterator[dict[str, Any]]:
    """Cells of each combination, the first varying slowest; a name such as 'radius, smaller' is of pairs."""
    values = [lists[value] if isinstance(value, str) else value for value in each.values()]
    for combination in product(*values):
        found: dict[str, Any] = {}
        for name, value in zip(each, combination, strict=True):
            parts = name.split(", ")
            found |= {name: value} if len(parts) == 1 else dict(zip(parts, value, strict=True))
        yield found


def _named(name: str, cells: Cells) -> float:
    """Number of a cell, of a threshold, or as it is written."""
    value = cells.get(name, THRESHOLDS.get(name, name))
    return float(number(value, {}, measures.NOTHING) if isinstance(value, str) and value != name else value)


def _checks(where: str, value: float | Array, limit: float | Array) -> list[Check]:
    if np.ndim(value) == np.ndim(limit) == 0:
        return [Check(where=where, value=float(value), limit=float(limit))]
    pairs = zip(*np.broadcast_arrays(value, limit), strict=True)
    return [
        Check(where=f"start {i}, {where}", value=float(one), limit=float(other))
        for i, (one, other) in enumerate(pairs, start=1)
    ]
