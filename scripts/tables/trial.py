"""Coverage of trials: docs/deployment/trial.md, from the repetitions that `scripts.trial_coverage` made before."""

import json
from pathlib import Path

from ffgym.core.files import read_text
from scripts.tables.page import DOCS, Contents, markdown
from scripts.trial_coverage import count_rows, count_trials

COVERAGE = DOCS / "deployment" / "trial_coverage.json"
"""Every repetition, with versions and seed."""


def coverage(file: Path = COVERAGE) -> Contents:
    """Count how often intervals hold the true gain, and what was claimed."""
    kept = json.loads(read_text(file))
    rows, counted = [], {}
    for machine in dict.fromkeys(row["machine"] for row in kept["rows"]):
        counts = counted[machine] = count_rows([row for row in kept["rows"] if row["machine"] == machine])
        for one in counts:
            of = one["repetitions"]
            covered, gain, worse = (f"{one[name]} of {of}" for name in ("covered", "gain_claimed", "worse_claimed"))
            sizes = tuple(f"{round(100 * one[name], 1) + 0.0:.1f} %" for name in ("truth", "width"))
            rows.append((machine, one["law"], one["program"], *sizes, covered, gain, worse))
    head = ("machine", "correction", "program", "true gain", "interval", "holds it", "gain claimed", "worse claimed")
    origin = kept["origin"]
    versions = ", ".join(f"{name} {version}" for name, version in origin["versions"].items())
    said = f"{origin['pairs']} pairs of each program, seed {origin['seed']}; {versions}."
    claims = []
    for law in dict.fromkeys(row["law"] for row in kept["rows"]):
        gains, losses = (count_trials(kept["rows"], law, claim) for claim in ("gain", "worse"))
        trials = len({(row["machine"], row["repetition"]) for row in kept["rows"] if row["law"] == law})
        claims.append(f"{law}: a gain in {gains} of {trials}, a loss in {losses}")
    said += f" Trials that claim something of any program or of all: {'; '.join(claims)}."
    return Contents(parts={"coverage": f"{markdown(head, rows)}\n\n{said}"}, numbers=counted)
