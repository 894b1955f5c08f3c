"""What a search has tried: one file, written whole after each trial."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from ffgym.core.errors import FFGymError
from ffgym.core.files import read_text, write_json

FAILED = 10.0
"""Value of a trial that failed: worse than any that learns, as of 22 000 times the error of the base; chosen."""


@dataclass(frozen=True, kw_only=True)
class Trial:
    """Hyper-parameters that were tried, and how good they are."""

    parameters: dict[str, float]
    """Of what is searched for."""
    value: float
    """Mean of ln(error / that of the base); FAILED where there is none."""
    failure: str | None = None
    """Why there is none."""
    folders: list[str]
    """Of its trainings, one for each seed."""


def read_trials(file: Path, search: Mapping[str, Any]) -> list[Trial]:
    """Trials of a search that were written, in their order; none if nothing was.

    Raises:
        FFGymError: if the file is of another search, or damaged.
    """
    from ffgym.agents.residual.training import check_same

    if not file.exists():
        return []
    try:
        tree = json.loads(read_text(file))
        theirs, trials = dict(tree["search"]), [Trial(**entry) for entry in tree["trials"]]
        found = [[trial.value, *trial.parameters.values()] for trial in trials]
    except (KeyError, TypeError, AttributeError, json.JSONDecodeError) as error:
        raise _damaged(file, error) from error
    check_same(theirs, search, file.parent, "search")
    if any(not isinstance(value, float) for row in found for value in row):
        raise _damaged(file, "a value is no number")
    if any(trial.parameters.keys() != search["space"].keys() for trial in trials):
        raise _damaged(file, "a trial is not of what is searched for")
    return trials


def write_trials(
    file: Path, search: Mapping[str, Any], trials: Sequence[Trial], best: Mapping[str, Any] | None
) -> None:
    """Write all trials of a search, and the best of them if there is one."""
    write_json(file, {"search": search, "best": best, "trials": [asdict(trial) for trial in trials]})


def _damaged(file: Path, why: object) -> FFGymError:
    return FFGymError(
        f"{file}: is damaged: {why}. Remove it and give the same command again; trainings that are done are not done "
        f"again."
    )
