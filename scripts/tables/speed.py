"""Speed and memory: docs/performance.md, from the last run that `make bench` stored."""

from pathlib import Path

from scripts.bench.history import read_history
from scripts.bench.turns import WIDE
from scripts.tables.page import DOCS, Contents, markdown

HISTORY = DOCS / "performance_history.jsonl"
"""Runs of the benchmark, a line each; `make bench` adds one."""


def speed(history: Path = HISTORY) -> Contents:
    """Tell the ratios and amounts of the last run, and where it was made."""
    runs = read_history(history)
    if not runs:
        return Contents(parts={"last run": "Not measured yet: no run of `make bench` is stored."})
    last = runs[-1]
    versions = ", ".join(f"{name} {version}" for name, version in last.versions.items())
    origin = f"Run of {last.date} at commit {last.commit} on {last.processor}; {versions}."
    tables = [
        markdown(("ratio", "median (quartiles)", ""), [_ratio(*each) for each in last.ratios.items()]),
        markdown(("figure", "value"), [(_cell(title), f"{x:.3g} {unit}") for title, (x, unit) in last.amounts.items()]),
    ]
    numbers = {"commit": last.commit, "ratios": last.ratios, "amounts": last.amounts}
    return Contents(parts={"last run": "\n\n".join([origin, *tables])}, numbers=numbers)


def _ratio(title: str, quartiles: tuple[float, float, float]) -> tuple[str, str, str]:
    """Row of a ratio; it says where the quartiles are far apart."""
    low, middle, high = quartiles
    wide = "WIDE" if high - low > WIDE * middle else ""
    return _cell(title), f"{middle:.3g} ({low:.3g} to {high:.3g})", wide


def _cell(title: str) -> str:
    """Title of a figure as it may stand in a table."""
    return title.replace("|", "\\|")
