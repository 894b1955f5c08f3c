"""A check: a figure of a recording, its limits, and why they are what they are."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import final

import numpy as np

from ffgym.logs.quality.finding import Finding, Verdict
from ffgym.logs.quality.log import Log


class NotJudgedError(Exception):
    """Raised by a check that the columns of a recording give no answer to; the text is the reason."""


@final
@dataclass(frozen=True, kw_only=True)
class Seen:
    """A figure that a check computed, before it is compared with the limits."""

    value: float
    message: str
    columns: tuple[str, ...] = ()
    joint: str = ""


@final
@dataclass(frozen=True, kw_only=True)
class Check:
    """One question to a recording. A figure is bad when it is above its limits."""

    name: str
    figure: str
    """What the number is."""
    unit: str
    flag: float | None
    """Above this, the figure is flagged; None if it never is."""
    refuse: float | None = None
    """Above this, it is refused; None if it never is."""
    why: str
    """Why the limits are where they are."""
    judge: Callable[[Log], Iterable[Seen]]
    every: bool = False
    """Keep figures that are in order, all of them; else only the worst is kept."""

    def findings(self, log: Log) -> tuple[Finding, ...]:
        """What the check says about a recording."""
        try:
            seen = tuple(self.judge(log))
        except NotJudgedError as reason:
            return (Finding(check=self.name, verdict="not judged", message=f"Not judged: {reason}."),)
        found = tuple(self._finding(entry) for entry in seen)
        bad = tuple(finding for finding in found if finding.verdict != "ok")
        if self.every or not found:
            return found
        return bad or (max(found, key=lambda finding: finding.value or 0.0),)

    def _finding(self, seen: Seen) -> Finding:
        verdict, limit = self._verdict(seen.value)
        return Finding(
            check=self.name,
            verdict=verdict,
            message=seen.message
            if verdict != "ok"
            else f"{self.figure} is {seen.value:.4g} {self.unit}".rstrip() + ".",
            columns=seen.columns,
            joint=seen.joint,
            value=seen.value if np.isfinite(seen.value) else None,
            unit=self.unit,
            limit=limit,
        )

    def _verdict(self, value: float) -> tuple[Verdict, float | None]:
        if self.refuse is not None and value > self.refuse:
            return "refused", self.refuse
        return ("flagged" if self.flag is not None and value > self.flag else "ok"), self.flag
