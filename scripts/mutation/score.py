"""Score of a room: the part of its mutants that tests notice."""

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from scipy import stats

from ffgym.core.errors import FFGymError
from ffgym.core.files import read_text
from scripts.mutation.mutants import Mutant
from scripts.mutation.testing import Outcome


@dataclass(frozen=True, kw_only=True)
class Score:
    """What became of the mutants of a room that were tested."""

    room: str
    seed: int
    """Seed of the draw."""
    n_mutants: int
    """Mutants that there are."""
    outcomes: tuple[Outcome, ...]

    @property
    def n_killed(self) -> int:
        """Mutants that a test noticed."""
        return sum(outcome.is_killed for outcome in self.outcomes)

    @property
    def share(self) -> float:
        """Share of those that were tested."""
        return self.n_killed / len(self.outcomes)

    def interval(self) -> tuple[float, float]:
        """Interval of 95 % of the share among all mutants, by Wilson."""
        found = stats.binomtest(self.n_killed, len(self.outcomes)).proportion_ci(0.95, "wilson")
        return float(found.low), float(found.high)

    def as_dict(self) -> dict[str, Any]:
        """Everything, for JSON."""
        outcomes = [asdict(outcome) for outcome in self.outcomes]
        numbers = {"seed": self.seed, "n_mutants": self.n_mutants, "n_killed": self.n_killed}
        return {"room": self.room, **numbers, "outcomes": outcomes}

    def __str__(self) -> str:
        low, high = self.interval()
        head = (
            f"{self.room}: {self.n_killed} of {len(self.outcomes)} killed, {self.share:.0%} ({low:.0%} to {high:.0%}) "
        )
        survived = [f"  {outcome}" for outcome in self.outcomes if not outcome.is_killed]
        return "\n".join([f"{head}of {self.n_mutants} mutants", *survived])


def read_outcomes(path: Path) -> list[Outcome]:
    """Read outcomes that were kept, the latest of a mutant last; none if there is no such file."""
    if not path.exists():
        return []
    try:
        return [_outcome(json.loads(line)) for line in read_text(path).splitlines()]
    except (ValueError, TypeError, KeyError) as error:
        raise FFGymError(
            f"{path}: holds no outcomes of mutants: {error}. Remove it, or choose another --out."
        ) from error


def read_score(row: dict[str, Any]) -> Score:
    """Read a score as `Score.as_dict` wrote it."""
    outcomes = tuple(_outcome(each) for each in row["outcomes"])
    return Score(room=row["room"], seed=row["seed"], n_mutants=row["n_mutants"], outcomes=outcomes)


def _outcome(row: dict[str, Any]) -> Outcome:
    """Outcome of its JSON form."""
    return Outcome(**{**row, "mutant": Mutant(**row["mutant"])})


def keep_outcome(path: Path, outcome: Outcome) -> None:
    """Add an outcome."""
    with open(path, "a", encoding="utf-8") as file:
        file.write(json.dumps(asdict(outcome)) + "\n")
