"""Count of what came of the inputs of each reader, kept in a file so that a run goes on where it was interrupted."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from ffgym.core.errors import FFGymError
from ffgym.core.files import is_file, read_text, write_json
from ffgym.core.typed_json import parse_json
from ffgym.report.table import Column, Table
from scripts.fuzz.outcome import ERROR, VALID, Outcome


@dataclass(kw_only=True)
class Count:
    """Outcomes of one reader."""

    inputs: int = 0
    """Inputs that were read; the next one has this number."""
    errors: int = 0
    """Clear errors."""
    valid: int = 0
    """Results."""
    findings: int = 0
    slowest_s: float = 0.0
    peak_mb: float = 0.0
    seconds: float = 0.0
    """Time of all inputs together."""

    def add(self, outcome: Outcome) -> None:
        """Count one more input."""
        self.inputs += 1
        self.errors += outcome.kind == ERROR
        self.valid += outcome.kind == VALID
        self.findings += not outcome.is_right
        self.slowest_s = max(self.slowest_s, outcome.seconds)
        self.peak_mb = max(self.peak_mb, outcome.peak_mb)
        self.seconds += outcome.seconds


@dataclass(kw_only=True)
class Tally:
    """Counts of all readers, and the findings."""

    seed: int
    counts: dict[str, Count] = field(default_factory=dict)
    findings: list[dict[str, Any]] = field(default_factory=list)
    """Reader, number, kind, detail and place of each, and the command that makes it again."""

    def add(self, reader: str, number: int, outcome: Outcome) -> dict[str, Any] | None:
        """Count an input; return the finding if it is one."""
        self.counts.setdefault(reader, Count()).add(outcome)
        if outcome.is_right:
            return None
        command = f"python -m scripts.fuzz --readers {reader} --seed {self.seed} --only {number}"
        found = {"reader": reader, "number": number, "kind": outcome.kind, "detail": outcome.detail}
        self.findings.append(found | {"place": outcome.place, "again": command})
        return self.findings[-1]

    def document(self) -> dict[str, Any]:
        """Convert to JSON."""
        counts = {name: asdict(count) for name, count in sorted(self.counts.items())}
        total = {key: sum(count[key] for count in counts.values()) for key in ("inputs", "errors", "valid", "findings")}
        return {"seed": self.seed, "total": total, "counts": counts, "findings": self.findings}


def load_tally(path: Path, seed: int) -> Tally:
    """Read the counts of an interrupted run; none where there is no file.

    Raises:
        FFGymError: if it is damaged, or of another seed.
    """
    if not is_file(path):
        return Tally(seed=seed)
    tree = parse_json(read_text(path), str(path), "Remove it to begin anew.")
    if tree.get("seed") != seed:
        raise FFGymError(f"{path}: is of seed {tree.get('seed')}, not of {seed}. Name another folder, or that seed.")
    counts = {name: Count(**count) for name, count in tree["counts"].items()}
    return Tally(seed=seed, counts=counts, findings=tree["findings"])


def save_tally(path: Path, tally: Tally) -> None:
    """Write the counts, whole or not at all."""
    write_json(path, tally.document())


def tally_table(counts: Mapping[str, Count]) -> Table:
    """Make the table of readers: inputs, clear errors, valid results, findings, slowest input, most memory."""
    every = [count for _, count in sorted(counts.items())]
    return Table(
        columns=(
            Column("reader", sorted(counts), kind="code"),
            Column("inputs", [f"{count.inputs:,}" for count in every]),
            Column("clear errors", [f"{count.errors:,}" for count in every]),
            Column("valid", [f"{count.valid:,}" for count in every]),
            Column("findings", [count.findings for count in every], form="d"),
            Column("slowest", [count.slowest_s for count in every], form=".2f", unit="s"),
            Column("most memory", [count.peak_mb for count in every], form=".0f", unit="MB"),
        )
    )
