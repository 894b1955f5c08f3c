"""History of the benchmark: a line for each run, and what a run has lost beside those before it."""

import json
import os
import platform
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from statistics import median

from ffgym.core.errors import FFGymError
from ffgym.core.files import read_text, write_text
from ffgym.core.provenance import versions
from scripts.bench.turns import WIDE, Amount, Ratio
from scripts.commit import describe_commit

LOST = 0.1
"""Part of a ratio whose loss is told."""
RECENT = 5
"""Runs whose median a ratio is compared with."""


def processor() -> str:
    """Name of the processor and number of cores."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return f"{names[0] if names else platform.processor() or platform.machine()}, {os.cpu_count()} cores"


@dataclass(frozen=True)
class Entry:
    """One run of the benchmark."""

    ratios: dict[str, tuple[float, float, float]]
    """Lower quartile, median and upper quartile by title."""
    amounts: dict[str, tuple[float, str]]
    """Value and unit by title."""
    date: str = field(default_factory=lambda: datetime.now(UTC).date().isoformat())
    commit: str = field(default_factory=describe_commit)
    processor: str = field(default_factory=processor)
    versions: dict[str, str] = field(default_factory=versions)

    @classmethod
    def of(cls, results: Iterable[Ratio | Amount]) -> "Entry":
        """Summarise results of this run."""
        ratios, amounts = {}, {}
        for result in results:
            if isinstance(result, Ratio):
                low, middle, high = (round(value, 4) for value in result.quartiles())
                ratios[result.title] = (low, middle, high)
            else:
                amounts[result.title] = (round(result.value, 4), result.unit)
        return cls(ratios, amounts)


def read_history(path: Path) -> list[Entry]:
    """Read the runs of a history, oldest first; none if there is no such file."""
    if not path.exists():
        return []
    lines = read_text(path).splitlines()
    try:
        return [Entry(**json.loads(line)) for line in lines]
    except (ValueError, TypeError) as error:
        raise FFGymError(f"{path}: is no history of the benchmark: {error}. Name another file.") from error


def append(path: Path, entry: Entry) -> None:
    """Add a run to a history."""
    before = read_text(path) if path.exists() else ""
    write_text(path, before + json.dumps(asdict(entry)) + "\n")


@dataclass(frozen=True)
class Change:
    """A ratio that is smaller than before."""

    title: str
    now: float
    before: float
    """Median of the runs that it is compared with."""
    runs: int
    first: str
    """Commit of the oldest of them."""
    elsewhere: bool
    """They were made on other processors."""
    sure: bool
    """The quartiles of this run are close to each other, and lie below, too."""

    def __str__(self) -> str:
        lost = f"{1 - self.now / self.before:.0%}"
        sure = f"LOST {lost}" if self.sure else f"lost {lost}, measure again"
        where = " on other processors" if self.elsewhere else ""
        runs = f"{self.runs} run{'s' * (self.runs > 1)}{where} since {self.first}"
        return f"{sure}: {self.title}: {self.now:.3g}, was {self.before:.3g} in {runs}"


def losses(entry: Entry, history: Sequence[Entry]) -> list[Change]:
    """Find the ratios that lost more than 10 % beside the median of recent runs, if any on the same processor."""
    found = []
    for title, (low, now, high) in entry.ratios.items():
        known = [each for each in history if title in each.ratios]
        here = [each for each in known if each.processor == entry.processor]
        compared = (here or known)[-RECENT:]
        if not compared:
            continue
        before = median(each.ratios[title][1] for each in compared)
        limit = (1 - LOST) * before
        if now < limit:
            sure = high < limit and high - low <= WIDE * now
            found.append(Change(title, now, before, len(compared), compared[0].commit, not here, sure))
    return found
