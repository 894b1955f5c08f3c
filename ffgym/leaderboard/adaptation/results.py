"""Results of adaptation as a file: the error left of every adapter, budget, machine and seed, motion by motion."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ffgym.core.errors import FFGymError
from ffgym.core.files import read_text, write_json
from ffgym.core.typed_json import from_json, parse_json, to_json

FORMAT = 1
"""Version of the file format."""


@dataclass(frozen=True, kw_only=True)
class AdaptationRun:
    """One adapter with one budget and seed on one machine."""

    adapter: str
    machine: str
    """Name of the plant."""
    laps: int
    """Budget in laps."""
    budget_s: float
    """Budget in seconds of motion."""
    robot_seconds: float
    """Seconds that the machine moved, at most the budget."""
    seed: int
    fingerprint: str
    """Fingerprint of the machine's physics."""
    versions: str
    artefact: str | None
    """sha256 of the file that the adapter was read from; None if there is none."""
    rms_um: tuple[float | None, ...]
    """RMS path error on each scored motion [um]."""

    @property
    def key(self) -> tuple[str, str, int, int]:
        """Identity: adapter, machine, laps, seed."""
        return self.adapter, self.machine, self.laps, self.seed


@dataclass(frozen=True, kw_only=True)
class AdaptationResults:
    """All runs of a round."""

    motions: tuple[str, ...]
    """Names of the scored motions."""
    lap: str
    """Name of the motion whose laps count the budgets."""
    runs: tuple[AdaptationRun, ...]


def write_results(path: Path, results: AdaptationResults) -> None:
    """Write results, whole or not at all."""
    tree: dict[str, Any] = {"format": FORMAT} | to_json(results)
    write_json(path, tree)


def read_results(path: Path) -> AdaptationResults:
    """Read results.

    Raises:
        FFGymError: if the file cannot be read, is damaged, or of another format.
    """
    tree = parse_json(read_text(path), str(path), "Remove it, and run the command again.")
    found = tree.pop("format", None) if isinstance(tree, dict) else None
    if found != FORMAT:
        raise FFGymError(f"{path}: has format {found!r}, this version of ffgym reads {FORMAT}.")
    results: AdaptationResults = from_json(AdaptationResults, tree, str(path))
    return results
