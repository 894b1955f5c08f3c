"""The frame of the quality gate: a check is a figure of a recording beside its limits, and one function.

What a check says stands in checks.toml; the function of the same name computes its figure.
"""

import tomllib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass, field
from importlib import resources
from typing import Any, Literal

import numpy as np

from ffgym.logs.quality.log import CheckedLog, NotJudgedError

Verdict = Literal["ok", "flagged", "refused", "not judged"]
"""`refused`: what depends on it must not be computed; `flagged`: it can, but the reader has to know."""

Overall = Literal["good", "usable", "insufficient"]
"""`good`: nothing flagged; `usable`: flagged, not refused; `insufficient`: something refused."""

SEVERITY: Mapping[Verdict, int] = {"refused": 0, "flagged": 1, "not judged": 2, "ok": 3}
"""Order in which findings are told."""


def load_table(name: str) -> dict[str, Any]:
    """Data of the gate in a TOML file beside this one."""
    return tomllib.loads((resources.files("ffgym.logs.quality") / name).read_text(encoding="utf-8"))


STAGE_ROWS: Mapping[str, Mapping[str, Mapping[str, Any]]] = load_table("checks.toml")
"""Stage -> check -> what it says."""

ROWS: Mapping[str, Mapping[str, Any]] = {name: row for rows in STAGE_ROWS.values() for name, row in rows.items()}
"""Check -> what it says."""


@dataclass(frozen=True, kw_only=True)
class Finding:
    """One figure of a recording beside its limit."""

    check: str
    """Name of the check (docs/quality.md)."""
    verdict: Verdict
    message: str
    """One sentence: the thing, its value, what is valid, the way out."""
    columns: tuple[str, ...] = ()
    """Columns that the finding is about; the first is the one most likely at fault."""
    joint: str = ""
    """Joint, where it is about one."""
    value: float | None = None
    unit: str = ""
    limit: float | None = None
    """The limit that the verdict compared with."""

    @property
    def place(self) -> str:
        """Joint or first column that it is about; empty if it is about the whole log."""
        return self.joint or next(iter(self.columns), "")


@dataclass(frozen=True, kw_only=True, eq=False)
class QualityReport:
    """All findings on one recording, the worst first."""

    robot: str
    segment: str
    n_rows: int
    duration: float
    """[s]."""
    findings: tuple[Finding, ...]
    conditioning: tuple[str, ...] = ()
    """Sentences on what conditioning did before."""

    @property
    def verdict(self) -> Overall:
        """Overall verdict: insufficient, usable or good."""
        verdicts = {finding.verdict for finding in self.findings}
        if "refused" in verdicts:
            return "insufficient"
        return "usable" if "flagged" in verdicts else "good"

    @property
    def problems(self) -> tuple[Finding, ...]:
        """Findings that are refused or flagged, refused ones first."""
        return tuple(f for f in self.findings if f.verdict in ("refused", "flagged"))

    def of(self, check: str) -> tuple[Finding, ...]:
        """Findings of one check."""
        return tuple(finding for finding in self.findings if finding.check == check)

    def numbers(self) -> dict[str, Any]:
        """Everything, as JSON has it."""
        head = {"robot": self.robot, "segment": self.segment, "rows": self.n_rows, "duration": self.duration}
        head |= {"verdict": self.verdict, "conditioning": list(self.conditioning)}
        return {**head, "findings": [asdict(finding) for finding in self.findings]}


@dataclass(frozen=True)
class Seen:
    """A figure that a check computed, before it is compared with the limits."""

    value: float
    columns: tuple[str, ...] = ()
    joint: str = ""
    words: Mapping[str, Any] = field(default_factory=dict)
    """Words of the check's message beside the value, by the names in its braces."""


@dataclass(frozen=True, kw_only=True)
class Check:
    """One question to a recording. A figure is bad when it is above its limits."""

    name: str
    judge: Callable[[CheckedLog], Iterable[Seen]]
    figure: str
    """Name of the number."""
    unit: str
    flag: float | None = None
    """Above this, the figure is flagged; None if it never is."""
    refuse: float | None = None
    """Above this, it is refused; None if it never is."""
    why: str
    """Why the limits are where they are."""
    message: str = ""
    """Statement about a figure above a limit."""
    every: bool = False
    """Keep figures that are in order, all of them; else only the worst is kept."""

    def findings(self, log: CheckedLog) -> tuple[Finding, ...]:
        """Check a recording."""
        try:
            found = tuple(self._finding(log, entry) for entry in self.judge(log))
        except NotJudgedError as reason:
            return (Finding(check=self.name, verdict="not judged", message=f"Not judged: {reason}."),)
        bad = tuple(finding for finding in found if finding.verdict != "ok")
        if self.every or not found:
            return found
        return bad or (max(found, key=lambda finding: finding.value or 0.0),)

    def _finding(self, log: CheckedLog, seen: Seen) -> Finding:
        verdict: Verdict = "ok"
        limit = self.flag
        if self.refuse is not None and seen.value > self.refuse:
            verdict, limit = "refused", self.refuse
        elif self.flag is not None and seen.value > self.flag:
            verdict = "flagged"
        message = f"{self.figure} is {seen.value:.4g} {self.unit}".rstrip() + "."
        if verdict != "ok":
            known = {"log": log, "header": log.recording.header, "robot": log.robot, "limit": self.flag}
            known |= {"value": seen.value, "columns": seen.columns, "joint": seen.joint}
            message = self.message.format(**known, **seen.words)
        return Finding(
            check=self.name,
            verdict=verdict,
            message=message,
            columns=seen.columns,
            joint=seen.joint,
            value=seen.value if np.isfinite(seen.value) else None,
            unit=self.unit,
            limit=limit,
        )


def check(judge: Callable[[CheckedLog], Iterable[Seen]], name: str = "") -> Check:
    """The check whose figure a function computes; its name, or `name`, is that of the entry in checks.toml."""
    name = name or judge.__name__.removeprefix("_")
    return Check(name=name, judge=judge, **ROWS[name])


def late(lag: float) -> str:
    """Word for the sign of a delay."""
    return "later" if lag > 0 else "earlier"
