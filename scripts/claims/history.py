"""What `make claims` made last of each step: in which time, on which day, by which commit, and what did not hold."""

import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from ffgym.core.files import read_text, write_json
from scripts.claims.records import FOLDER
from scripts.claims.steps import Made, Step

HISTORY = FOLDER / "claims.json"
"""File of it, from which docs/claims.md is made."""


def keep_made(made: Iterable[Made], steps: Sequence[Step], numbers: Mapping[str, int], file: Path = HISTORY) -> None:
    """Keep what was made beside what earlier calls made; steps that are no more go.

    Args:
        made: what came of steps; what was skipped is left out.
        steps: all that there are; those that were never made are kept as such.
        numbers: numbers of the documentation, how many of them are traced, and how many did not hold besides those of
            steps.
        file: what is kept.
    """
    known = {one["name"]: one for one in json.loads(read_text(file))["steps"]} if file.exists() else {}
    for one in made:
        if not one.skipped:
            faults = len(one.faults)
            known[one.name] = {"seconds": one.seconds, "date": one.date, "commit": one.commit, "faults": faults}
    rows = [{"name": each.name, **known.get(each.name, {})} for each in steps]
    write_json(file, {"numbers": dict(numbers), "steps": rows})
