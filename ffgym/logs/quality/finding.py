"""What a check found in a recording, and the report of all of them."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal, final

from ffgym.core.types import Array

Verdict = Literal["ok", "flagged", "refused", "not judged"]
"""`refused`: what depends on it must not be computed; `flagged`: it can, but the reader has to know."""

Overall = Literal["good", "usable", "insufficient"]
"""`good`: nothing flagged; `usable`: flagged, not refused; `insufficient`: something refused."""

_SEVERITY: Mapping[Verdict, int] = {"refused": 0, "flagged": 1, "not judged": 2, "ok": 3}


@final
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


@final
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
    """What conditioning did before, in sentences."""

    @property
    def verdict(self) -> Overall:
        """What the recording is good for."""
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


def worst_first(findings: Sequence[Finding]) -> tuple[Finding, ...]:
    """Findings by severity; those of one severity stay in the order of the checks."""
    return tuple(sorted(findings, key=lambda finding: _SEVERITY[finding.verdict]))


def span_text(t: Array, rows: slice) -> str:
    """Where `rows` lie on the clock, for messages."""
    return f"from {t[rows.start]:.4g} to {t[rows.stop - 1]:.4g} s"
