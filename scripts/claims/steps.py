"""What `make claims` makes again in minutes to hours: parts of pages, stored records, and tests that marks name."""

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, field
from datetime import UTC, datetime
from fnmatch import fnmatchcase
from functools import partial
from itertools import groupby, zip_longest
from pathlib import Path

from ffgym.core.errors import FFGymError
from ffgym.core.files import read_text, write_json
from scripts.claims.numerals import NUMERAL
from scripts.claims.page import ROOT, Mark, name_of, pages, read_blocks
from scripts.claims.records import RECORDS, make_record
from scripts.claims.trace import PRINTED, Fault
from scripts.commit import describe_commit
from scripts.tables import DEFINED, PAGES
from scripts.tables.page import DOCS, renew


@dataclass(frozen=True)
class Step:
    """One thing that is made again."""

    name: str
    command: str
    make: Callable[[], list[Fault]]


@dataclass(frozen=True)
class Made:
    """What came of a step."""

    name: str
    seconds: float
    faults: tuple[Fault, ...]
    skipped: str = ""
    """Reason why it was not made, as data that are not there."""
    date: str = field(default_factory=lambda: datetime.now(UTC).date().isoformat())
    commit: str = field(default_factory=describe_commit)


def every_step(folder: Path) -> list[Step]:
    """List all steps, quick ones first; new records are written to a folder."""
    parts = [
        Step(f"page {name}", f"python -m scripts.tables --page {name}", partial(_compare_page, name))
        for name in (*DEFINED, *(name for name in PAGES if name not in DEFINED))
        if name != "claims.md"  # it is made from what came of these steps
    ]
    records = [Step(f"record {name}", each.command, partial(_again, name, folder)) for name, each in RECORDS.items()]
    named = sorted({mark.text.partition(" for ")[0] for mark in _marks("tested")} | set(PRINTED.values()))
    by_file = {file: list(own) for file, own in groupby(named, key=lambda test: test.partition("::")[0])}
    tests = [Step(file, f"python -m pytest {' '.join(own)}", partial(_run_tests, own)) for file, own in by_file.items()]
    return [*parts, *tests, *records]


def choose_steps(steps: Sequence[Step], patterns: Sequence[str]) -> list[Step]:
    """Choose the steps whose name matches one of some patterns, as `page agents/*` or `tests/*`; none given is all.

    Raises:
        FFGymError: if a pattern matches no step.
    """
    for pattern in patterns:
        if not any(fnmatchcase(step.name, pattern) for step in steps):
            kinds = "'page PLACE' in docs/, 'record NAME' in docs/records, and files of tests"
            raise FFGymError(f"No step is named {pattern!r}; there are {kinds}, with * for any part of a name.")
    return [step for step in steps if not patterns or any(fnmatchcase(step.name, each) for each in patterns)]


def run_steps(steps: Sequence[Step], folder: Path, state: str) -> Iterator[Made]:
    """Run steps, or read what an interrupted call has made by the same code, and yield what came.

    A step of which something did not hold is made again, as the page may have been mended.
    """
    kept = folder / "steps.json"
    done = json.loads(read_text(kept)) if kept.exists() else {}
    if done.get("state") != state:
        done = {"state": state, "made": {}}
    for step in steps:
        known = done["made"].get(step.name)
        if known is None or known["faults"]:
            began = time.monotonic()
            try:
                faults, skipped = step.make(), ""
            except FFGymError as error:
                faults, skipped = [], str(error)
            made = Made(step.name, round(time.monotonic() - began, 1), tuple(faults), skipped)
            done["made"][step.name] = asdict(made)
            write_json(kept, done)
        found = done["made"][step.name]
        yield Made(**{**found, "faults": tuple(Fault(**fault) for fault in found["faults"])})


def _marks(kind: str) -> list[Mark]:
    """List the marks of a kind on all pages."""
    return [mark for page in pages() for block in read_blocks(page) for mark in block.marks if mark.kind == kind]


def _compare_page(name: str) -> list[Fault]:
    """Make the parts of a page again, and list the numbers that differ."""
    text = read_text(DOCS / name)
    command = f"python -m scripts.tables --page {name}"
    return list(compare_text(name_of(DOCS / name), text, renew(text, PAGES[name]().parts), command))


def compare_text(page: str, old: str, new: str, command: str) -> Iterator[Fault]:
    """Yield the numerals of a page that are others in a page that was made again, or lines where words differ."""
    for line, (before, after) in enumerate(zip_longest(old.splitlines(), new.splitlines()), start=1):
        if before == after:
            continue
        if before is None or after is None or NUMERAL.sub("#", before) != NUMERAL.sub("#", after):
            yield Fault(page, line, f"says {before!r}, is {after!r} ({command})")
            continue
        for says, value in zip(NUMERAL.findall(before), NUMERAL.findall(after), strict=True):
            if says != value:
                yield Fault(page, line, f"says {says}, is {value} ({command})")


def _again(name: str, folder: Path) -> list[Fault]:
    """Make a record again; what claims tell of it is compared with the pages after all steps."""
    try:
        make_record(name, folder)
    except FFGymError as error:
        return [Fault(f"docs/records/{name}.json", 0, str(error))]
    return []


def _run_tests(tests: Sequence[str]) -> list[Fault]:
    """Run tests, and list those that fail."""
    call = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-m", "", "-rf", *tests]
    ended = subprocess.run(call, cwd=ROOT, check=False, capture_output=True, text=True, env={**os.environ})
    failed = [line.split()[1] for line in ended.stdout.splitlines() if line.startswith(("FAILED ", "ERROR "))]
    if ended.returncode and not failed:
        raise FFGymError(f"pytest ended with {ended.returncode}: {ended.stdout.strip().splitlines()[-1:]}")
    return [Fault(test.partition("::")[0], 0, f"fails: {test}") for test in failed]
