"""Claims of the thesis as rows of a table, and how they are judged: by comparing numbers measured in results."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from inspect import signature
from itertools import product
from typing import Any, Literal

import numpy as np

from ffgym.report import law_styles
from ffgym.report.circles.comparison import FACTOR as FACTOR
from scripts.thesis import measures
from scripts.thesis.measures import BEND as BEND
from scripts.thesis.studies import ThesisStudies

Verdict = Literal["holds", "partly", "does not hold", "not comparable"]
VERDICTS: tuple[Verdict, ...] = ("holds", "partly", "does not hold", "not comparable")

EVERY = 1.0
"""Share of comparisons that must be true where the thesis speaks of all: every one."""
MOST = 0.75
"""The same where it says 'in general', 'most' or 'almost all'; chosen, as for the findings of the demo's report."""
MAJORITY = 0.5
"""The same where it says 'more often' or 'a majority'."""
PARTLY = 0.5
"""Share that must be true for 'partly'; chosen: at least as much speaks for the claim as against it."""

CLEAR = 0.25
"""Share of an error that must be gone where the thesis says 'significant'; chosen: below every mean reduction that it
calls so (32 % and more, Tables 4.1 and 5.1)."""
KEPT = 1 - CLEAR
"""Share that may then be left."""
ZERO = 0.05
"""Share of the uncompensated value that counts as 'zero' or 'the same curve'; chosen: a line's width in a figure."""
SIMILAR = 0.15
"""Reductions that differ by less count as similar; chosen: static and dynamic LuGre are 0.14 apart on the real robot
(Table 4.1), which the thesis calls similar (4.5)."""
ROUGH = 0.30
"""RMS difference over RMS friction that a 'reasonable approximation' may have; chosen before any network was looked at.
It is strict: static LuGre itself is 34 to 79 % off dynamic LuGre (p1, 10 mm/s). docs/reproduction.md says which
verdicts another value would change."""
BROKEN = 0.7
"""Share of the path error of dynamic LuGre that must be gone for its limit to count as broken; chosen."""
GOOD_FIT = 90.0
"""Fit [%] from which a curve is called a good fit; chosen: the difference is then a tenth of the friction's swing."""

INPUT_RANGE = 20.0
"""Largest motor speed [rad/s] at 100 mm/s as thesis 5.1.1 reads it from Figure 5.2."""
QUICK = 5
"""Iterations that count as quick: a third of the 15 of thesis 5.3.1; chosen."""
REST = 0.1
"""Share of the whole fall that may be left after them; chosen."""

THRESHOLDS: dict[str, float] = {name: value for name, value in vars().items() if isinstance(value, int | float)}
"""All of these by name, for the table of claims."""


@dataclass(frozen=True, kw_only=True)
class Check:
    """One comparison of two numbers; it is true if `value` is below `limit`."""

    where: str
    """Compared quantity, with its unit, e.g. 'static LuGre, r = 1 mm [mm]'."""
    value: float
    limit: float

    @property
    def true(self) -> bool:
        """Tell whether the comparison comes out as the claim says."""
        return self.value < self.limit

    @property
    def text(self) -> str:
        """The comparison in numbers."""
        return f"{self.where}: {self.value:.3g} {'<' if self.true else 'is not <'} {self.limit:.3g}"


@dataclass(frozen=True, kw_only=True, eq=False)
class Claim:
    """A statement of the thesis about one of its figures or tables."""

    name: str
    """Unique, e.g. '4.6-roundness'."""
    statement: str
    """Statement of the thesis, in our words."""
    criterion: str
    """Numbers that decide, and the condition on them; where nothing can decide, the reason."""
    checks: Callable[[ThesisStudies], Sequence[Check]]
    """The comparisons; none if nothing comparable was published or can be simulated."""
    share: float = EVERY
    """Share of them that must be true."""
    published: Callable[[ThesisStudies], Sequence[Check]] = lambda studies: ()
    """The same comparisons of the numbers in a published table, where there is one. They decide nothing here; they say
    whether the thesis' own numbers bear the claim."""
    fitted: Callable[[ThesisStudies], Sequence[Check]] = lambda studies: ()
    """The same comparisons of cells that the robot was fitted to. They decide nothing: agreement there is by design."""


@dataclass(frozen=True, kw_only=True)
class Judgement:
    """A claim with its verdict."""

    claim: Claim
    verdict: Verdict
    checks: tuple[Check, ...]
    published: tuple[Check, ...] = ()
    """The same of published numbers, for comparison."""
    fitted: tuple[Check, ...] = ()
    """The same of fitted cells, for comparison."""

    @property
    def text(self) -> str:
        """The numbers that decide, in one line; of many comparisons those that are not true."""
        words = self._decisive
        for name, checks in (("published numbers themselves", self.published), ("cells that were fitted", self.fitted)):
            if checks:
                words += f" Of the {name}: {sum(check.true for check in checks)} of {len(checks)}."
        return words

    @property
    def _decisive(self) -> str:
        if not self.checks:
            return self.claim.criterion
        true = sum(check.true for check in self.checks)
        count = f"{true} of {len(self.checks)} true"
        if len(self.checks) <= _LISTED:
            return f"{count}: {'; '.join(check.text for check in self.checks)}."
        wrong = [check.text for check in self.checks if not check.true]
        if not wrong:  # the one that is nearest to being false
            closest = max(self.checks, key=lambda check: check.value / check.limit if check.limit > 0 else 1.0)
            return f"{count}, the closest {closest.text}."
        more = f"; and {len(wrong) - _LISTED} more" if len(wrong) > _LISTED else ""
        return f"{count}; not {'; '.join(wrong[:_LISTED])}{more}."


_LISTED = 3
"""Comparisons that one line has room for."""


def judge(claim: Claim, studies: ThesisStudies) -> Judgement:
    """Simulate what the claim needs, if that has not been done, and compare."""
    checks, published, fitted = (tuple(part(studies)) for part in (claim.checks, claim.published, claim.fitted))
    verdict = verdict_of(checks, claim.share)
    return Judgement(claim=claim, verdict=verdict, checks=checks, published=published, fitted=fitted)


def verdict_of(checks: Sequence[Check], share: float = EVERY) -> Verdict:
    """Verdict by the share of comparisons that are true."""
    if not checks:
        return "not comparable"
    true = sum(check.true for check in checks) / len(checks)
    return "holds" if true >= share else "partly" if true >= PARTLY else "does not hold"


Cells = Mapping[str, Any]
"""Cells of the table by name, e.g. law, position and speed [m/s]; see `claims.toml`."""

RULES = ("kind", "each", "but", "fitted", "checks", "where", "value", "limit")
"""Entries of a row that say how to compare; the others are cells."""


def compare(row: Cells, cells: Cells, table: Cells, studies: ThesisStudies, *, fitted: bool = False) -> list[Check]:
    """Comparisons of a row of the table, in the order of its `each`.

    Args:
        row: the row, or one of its `checks`.
        cells: cells that it shares with others.
        table: the whole table, for its lists and kinds.
        studies: whose results are measured; what it does not have (None) is not compared.
        fitted: take the combinations that the row marks as fitted, instead of all others.
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
                checks += compare(part, here, table, studies, fitted=fitted)
        elif fitted == ("fitted" in row and row["fitted"].items() <= here.items()):
            value, limit = (number(row[side], here, studies) for side in ("value", "limit"))
            if value is None or limit is None:
                continue
            where = text(row["where"], here)
            if np.ndim(value) == np.ndim(limit) == 0:
                checks.append(Check(where=where, value=float(value), limit=float(limit)))
                continue
            for start, (one, other) in enumerate(zip(*np.broadcast_arrays(value, limit), strict=True), start=1):
                checks.append(Check(where=f"start {start}, {where}", value=float(one), limit=float(other)))
    return checks


def number(entry: Any, cells: Cells, studies: ThesisStudies) -> Any:
    """Number that an entry of the table stands for, or one per random start; None where nothing can be measured."""
    if isinstance(entry, str):
        first, _, second = entry.rpartition(" - ")
        return _name(first, cells) - _name(second, cells) if first else _name(second, cells)
    if not isinstance(entry, Mapping):
        return entry
    if "apart" in entry:
        one, other = (number(each, cells, studies) for each in entry["apart"])
        return abs(one - other)
    found = call(getattr(measures, entry["measure"]), studies, {**cells, **entry})
    return None if found is None else number(entry.get("times", 1.0), cells, studies) * found


def call(function: Callable[..., Any], studies: ThesisStudies, cells: Cells) -> Any:
    """Call a function of the studies with those of the cells that it asks for."""
    known = THRESHOLDS | measures.RECORDS | dict(cells)
    asked = {name: cells[name] for name in signature(function).parameters if name in cells}
    named = {name: known[value[1:]] for name, value in asked.items() if str(value).startswith("$")}
    return function(studies, **asked | named)


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


def _name(name: str, cells: Cells) -> float:
    """Number of a cell, of a threshold, or as it is written."""
    value = cells.get(name, THRESHOLDS.get(name, name))
    return float(number(value, {}, measures.NOTHING) if isinstance(value, str) and value != name else value)
