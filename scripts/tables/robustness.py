"""Damaged files: docs/robustness.md, from the run that `make fuzz` made before."""

from pathlib import Path

from ffgym.core.files import read_text
from ffgym.core.typed_json import parse_json
from scripts.fuzz.tally import Count, tally_table
from scripts.tables.page import DOCS, Contents

RECORD = DOCS / "robustness.json"
"""Counts of each reader, with versions and seed."""


def inputs(file: Path = RECORD) -> Contents:
    """Count what came of the inputs of each reader."""
    kept = parse_json(read_text(file), str(file))
    counts = {name: Count(**count) for name, count in kept["counts"].items()}
    total = {key: f"{value:,}" for key, value in kept["total"].items()}
    versions = ", ".join(f"{name} {version}" for name, version in kept["versions"].items())
    findings = f"{total['findings']} finding{'s' * (kept['total']['findings'] != 1)}"
    slowest = max(counts.values(), key=lambda count: count.slowest_s)
    largest = max(counts.values(), key=lambda count: count.peak_mb)
    said = (
        f"{total['inputs']} inputs of seed {kept['seed']}: {total['errors']} clear errors, {total['valid']} results, "
        f"{findings}; the slowest took {slowest.slowest_s:.1f} s, most memory was "
        f"{largest.peak_mb:.0f} MB, with all that a process had imported; {versions}."
    )
    return Contents(parts={"inputs": f"{said}\n\n{tally_table(counts).markdown()}"}, numbers=kept["total"])
