"""Claims of the thesis, and how they are judged: by comparing numbers, one verdict each."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from ffgym.report.circles.comparison import FACTOR as FACTOR

if TYPE_CHECKING:
    from scripts.thesis.laboratory import Laboratory

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

BEND = 1.0
"""Motor speed [rad/s] below which the thesis sees friction's nonlinearity (5.1.1)."""
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
    """What is compared, with its unit, e.g. 'static LuGre, r = 1 mm [mm]'."""
    value: float
    limit: float

    @property
    def true(self) -> bool:
        """Whether the comparison comes out as the claim says."""
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
    """What the thesis says, in our words."""
    criterion: str
    """Which numbers decide, and what must be true of them; where nothing can decide, why."""
    checks: Callable[["Laboratory"], Sequence[Check]]
    """The comparisons; none if nothing comparable was published or can be simulated."""
    share: float = EVERY
    """Share of them that must be true."""
    published: Callable[["Laboratory"], Sequence[Check]] = lambda laboratory: ()
    """The same comparisons of the numbers in a published table, where there is one. They decide nothing here; they say
    whether the thesis' own numbers bear the claim."""


@dataclass(frozen=True, kw_only=True)
class Judgement:
    """A claim with its verdict."""

    claim: Claim
    verdict: Verdict
    checks: tuple[Check, ...]
    published: tuple[Check, ...] = ()
    """The same of published numbers, for comparison."""

    @property
    def text(self) -> str:
        """The numbers that decide, in one line; of many comparisons those that are not true."""
        if not self.published:
            return self._decisive
        true = sum(check.true for check in self.published)
        return f"{self._decisive} Of the published numbers themselves: {true} of {len(self.published)}."

    @property
    def _decisive(self) -> str:
        if not self.checks:
            return self.claim.criterion
        true = sum(check.true for check in self.checks)
        count = f"{true} of {len(self.checks)} true"
        if len(self.checks) <= _LISTED:
            return f"{count}: {'; '.join(check.text for check in self.checks)}."
        wrong = [check.text for check in self.checks if not check.true]
        if not wrong:
            return f"{count}, the closest {max(self.checks, key=_closeness).text}."
        more = f"; and {len(wrong) - _LISTED} more" if len(wrong) > _LISTED else ""
        return f"{count}; not {'; '.join(wrong[:_LISTED])}{more}."


_LISTED = 3
"""Comparisons that one line has room for."""


def judge(claim: Claim, laboratory: "Laboratory") -> Judgement:
    """Simulate what the claim needs, if that has not been done, and compare."""
    checks = tuple(claim.checks(laboratory))
    published = tuple(claim.published(laboratory))
    return Judgement(claim=claim, verdict=verdict_of(checks, claim.share), checks=checks, published=published)


def verdict_of(checks: Sequence[Check], share: float = EVERY) -> Verdict:
    """Verdict by the share of comparisons that are true."""
    if not checks:
        return "not comparable"
    true = sum(check.true for check in checks) / len(checks)
    return "holds" if true >= share else "partly" if true >= PARTLY else "does not hold"


def _closeness(check: Check) -> float:
    """How near a true comparison is to being false, 1 is nearest."""
    return check.value / check.limit if check.limit > 0 else 1.0
