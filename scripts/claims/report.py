"""What `make claims` says: numbers that do not hold, and how many are traced by what, for each page."""

from collections import Counter
from collections.abc import Mapping, Sequence
from types import MappingProxyType

from ffgym.report import Table
from scripts.claims.trace import HOW, Fault, Trace

HEADINGS: Mapping[str, str] = MappingProxyType(
    {"made": "made", "claim": "claim", "tested": "tested", "printed": "printed", "cited": "cited"}
    | {"example": "example", "input": "input", "name": "no claim", "untraced": "untraced"}
)
"""Headings of the ways to trace a number."""


def count(traces: Sequence[Trace]) -> dict[str, dict[str, int]]:
    """Count numbers of each page by what traces them."""
    counted = {}
    for trace in traces:
        found = Counter(each.how for each in trace.numerals)
        counted[trace.page] = {how: found[how] for how in HOW}
    return counted


def count_all(traces: Sequence[Trace]) -> dict[str, int]:
    """Count pages, numbers and those that are traced."""
    found = [each.how for trace in traces for each in trace.numerals]
    return {"pages": len(traces), "numbers": len(found), "traced": len(found) - found.count("untraced")}


def describe(traces: Sequence[Trace]) -> str:
    """Table of all pages, those with most untraced numbers first, and the sum."""
    counted = count(traces)
    total = {how: sum(page[how] for page in counted.values()) for how in HOW}
    rows = sorted(counted.items(), key=lambda item: (-item[1]["untraced"], item[0]))
    table = [
        (name, str(sum(page.values())), *(str(page[how] or "") for how in HOW), _share(page))
        for name, page in (*rows, ("all pages", total))
    ]
    return Table.of_rows(("page", "numbers", *(HEADINGS[how] for how in HOW), "traced"), table).markdown(aligned=True)


def _share(page: Mapping[str, int]) -> str:
    every = sum(page.values())
    return f"{1 - page['untraced'] / every:.1%}" if every else ""


def list_untraced(traces: Sequence[Trace]) -> list[Fault]:
    """List numbers that nothing traces, a line of a page each."""
    return [
        Fault(trace.page, line, f"{', '.join(numbers)}: traced by nothing; name what makes it (docs/claims.md)")
        for trace in traces
        for line, numbers in _by_line(trace).items()
    ]


def _by_line(trace: Trace) -> dict[int, list[str]]:
    found: dict[int, list[str]] = {}
    for each in trace.untraced:
        found.setdefault(each.line, []).append(each.text)
    return found
