"""Results that take minutes, stored in docs/records with the command that makes them, its date, versions and time.

Claims tell of the stored ones; `make claims` makes them again, and the same claims tell of the new ones.
"""

import json
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from tempfile import TemporaryDirectory
from types import MappingProxyType
from typing import Any

from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.files import made_folder, read_text, write_json
from ffgym.core.provenance import versions
from scripts.claims.page import ROOT
from scripts.commit import describe_commit

FOLDER = ROOT / "docs" / "records"
"""Folder of the stored records."""


@dataclass(frozen=True)
class Record:
    """A result that a script writes as JSON."""

    module: str
    """Module that is run, e.g. scripts.thesis."""
    options: tuple[str, ...] = ()
    """Its options, without the file of the result."""

    @property
    def command(self) -> str:
        """Command as a reader types it."""
        return " ".join(("python -m", self.module, *self.options))


RECORDS: Mapping[str, Record] = MappingProxyType(
    {
        "adaptation_bounds": Record("scripts.adaptation_bounds"),
        "corrected_program": Record("scripts.claims.corrected_program"),
        "example_diagnosis": Record("scripts.claims.example_diagnosis"),
        "networks": Record(
            "ffgym",
            (
                *("demo", "--agents", "none", "lugre_static", "lugre_dynamic"),
                *("bsn_static", "bsn_extended", "bsn_extended_prior", "narx", "mlp_fel", "residual_gp"),
                *("--no-diagnosis", "--report", "out/networks.html"),
            ),
        ),
        "session": Record("scripts.claims.session"),
        "slow_triangle": Record("scripts.claims.slow_triangle"),
        "thesis": Record("scripts.thesis"),
        "workcell": Record("scripts.calibrate_workcell", ("--table", "--fitted")),
        "workcell_arm": Record("scripts.calibrate_workcell", ("--table", "--fitted", "--workcell", "thesis_arm")),
    }
)
"""Stored results by the name of their file."""

_places = [FOLDER]


@contextmanager
def records_in(folder: Path) -> Iterator[None]:
    """Let claims read records of another folder while the block runs, and those that it lacks from the stored ones."""
    _places.insert(0, folder)
    try:
        yield
    finally:
        _places.remove(folder)


def numbers_of(name: str) -> Any:
    """Read the numbers of a record."""
    check_choice("record", name, list(RECORDS))
    place = next((each for folder in _places if (each := folder / f"{name}.json").exists()), None)
    if place is None:
        raise FFGymError(f"The record {name!r} is not stored; run python -m scripts.claims --record {name}.")
    return json.loads(read_text(place))["numbers"]


def make_record(name: str, folder: Path = FOLDER) -> Path:
    """Run the command of a record, and store what it writes; returns the file.

    Raises:
        FFGymError: if the command fails.
    """
    record = RECORDS[check_choice("record", name, list(RECORDS))]
    place, began = folder / f"{name}.json", time.monotonic()
    with TemporaryDirectory() as scratch, made_folder(folder):
        made = Path(scratch) / place.name
        options = (option.replace("out/", f"{scratch}/") for option in record.options)
        call = [sys.executable, "-m", record.module, *options, "--json", str(made)]
        ended = subprocess.run(call, cwd=ROOT, check=False, capture_output=True, text=True)
        if ended.returncode:
            raise FFGymError(f"{record.command} failed: {ended.stderr.strip().splitlines()[-1:]}")
        # no place of this computer in a record
        text = read_text(made).replace(str(made), place.name).replace(scratch, "out")
        store(name, json.loads(text), time.monotonic() - began, place)
    return place


def store(name: str, numbers: Any, seconds: float, place: Path) -> None:
    """Store numbers with their origin."""
    origin = {
        "command": RECORDS[name].command,
        "made": datetime.now(UTC).date().isoformat(),
        "commit": describe_commit(),
        "seconds": round(seconds),
        "versions": versions(),
    }
    write_json(place, {"origin": origin, "numbers": numbers})
