"""Tables of docs/reproduction.md, from the stored record of `python -m scripts.thesis`."""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from scripts.claims.records import numbers_of
from scripts.tables.page import Contents, markdown

CHAPTERS = {"chapter-4": "4", "chapter-5": "5", "chapter-6": "6", "beyond": "beyond"}
"""Chapters whose claims are counted, and how the page calls them."""
VERDICTS = ("holds", "partly", "does not hold", "not comparable")
SIZES = {
    "T4.1-sizes": "4.1, LuGre at 10 mm/s",
    "T4.2-sizes": "4.2, LuGre at 40 mm/s",
    "T5.1-sizes": "5.1, networks at 10 mm/s",
    "T5.2-sizes": "5.2, networks at 40 mm/s",
}
"""Claims on the sizes of path errors, by the table that they are about."""


def items() -> dict[str, dict[str, Any]]:
    """Read the reproduced figures and tables by name."""
    return {item["name"]: item for item in numbers_of("thesis")["items"]}


def claim_of(name: str) -> dict[str, Any]:
    """Find a claim of the thesis by its name."""
    (found,) = (each for item in items().values() for each in item["claims"] if each["name"] == name)
    result: dict[str, Any] = found
    return result


def hold(checks: Sequence[Mapping[str, Any]]) -> str:
    """Say how many comparisons are true, as '9 of 24'."""
    return f"{sum(check['true'] for check in checks)} of {len(checks)}"


def count_verdicts() -> dict[str, Counter[str]]:
    """Count the verdicts of the claims of each chapter."""
    counted: dict[str, Counter[str]] = {chapter: Counter() for chapter in CHAPTERS}
    for item in items().values():
        if item["chapter"] in counted:
            counted[item["chapter"]].update(each["verdict"] for each in item["claims"])
    return counted


def reproduction() -> Contents:
    """Verdicts of each chapter, sizes of path errors, and what lies beyond the thesis."""
    counted = count_verdicts()
    verdicts = [
        (CHAPTERS[chapter], str(counts.total()), *(str(counts[verdict]) for verdict in VERDICTS))
        for chapter, counts in counted.items()
    ]
    sizes = []
    for name, title in SIZES.items():
        found = claim_of(name)
        sizes.append((title, hold(found["checks"]), hold(found["fitted"]), found["verdict"]))
    return Contents(
        parts={
            "verdicts": markdown(("chapter", "claims", *VERDICTS), verdicts),
            "sizes": markdown(("table", "held out, with compensation", "fitted, without", "verdict"), sizes),
            "agents": _table("agents", 0, left_out=("what it may know",)),
            "other speeds": _table("other-speeds", 0),
            "reidentified": _table("reidentified", 0),
        }
    )


def _table(item: str, number: int, left_out: Sequence[str] = ()) -> str:
    """Format a table of the record."""
    found = items()[item]["numbers"][number]
    kept = [k for k, heading in enumerate(found["headings"]) if heading not in left_out]
    rows = [[row[k] for k in kept] for row in found["rows"]]
    return markdown([found["headings"][k] for k in kept], rows)
