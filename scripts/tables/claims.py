"""Numbers that were made again: docs/claims.md, from what `make claims` kept of each step."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ffgym.core.files import read_text
from scripts.tables.page import DOCS, Contents, markdown

KEPT = DOCS / "records" / "claims.json"
"""Each step, and when it was made last, in which time, by which commit."""
QUICK = 10.0
"""Time of a step [s] up to which it is told with the others that are as quick."""


def made_again(file: Path = KEPT) -> Contents:
    """Tell when each step was made last, and how many numbers there are."""
    kept = json.loads(read_text(file))
    steps, numbers = kept["steps"], kept["numbers"]
    made = [step for step in steps if "date" in step]
    quick = [step for step in made if step["seconds"] <= QUICK]
    rows = [_row(f"{len(quick)} of {QUICK:.0f} s and less", quick)] if quick else []
    rows += [_row(f"`{step['name']}`", [step]) for step in made if step not in quick]
    rows += [(f"`{step['name']}`", "", "not yet") for step in steps if step not in made]
    hours = sum(step["seconds"] for step in made) / 3600
    faults = numbers["faults"] + sum(step["faults"] for step in made)
    holds = f"{faults} do not hold" if faults else "all hold"
    said = (
        f"{numbers['numbers']:,} numbers on {numbers['pages']} pages, {numbers['traced']:,} of them traced; {holds}. "
        f"{len(made)} of {len(steps)} steps were made again, in {hours:.1f} h."
    )
    table = markdown(("step", "time", "made last"), rows)
    return Contents(parts={"made again": f"{said}\n\n{table}"}, numbers=numbers)


def _row(name: str, steps: Sequence[Mapping[str, Any]]) -> tuple[str, str, str]:
    """Tell time, days and commits of steps, and what did not hold."""
    seconds = sum(step["seconds"] for step in steps)
    time = f"{seconds / 60:.0f} min" if seconds >= 90 else f"{seconds:.0f} s"
    made = ", ".join(sorted({f"{step['date']} by {step['commit']}" for step in steps}))
    faults = sum(step["faults"] for step in steps)
    return name, time, made + (f"; {faults} did not hold" if faults else "")
