"""Tests of mutants, in a copy of the repository."""

import hashlib
import json
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ffgym.core.errors import FFGymError
from ffgym.core.files import read_text, write_json
from scripts.mutation.mutants import Mutant
from scripts.mutation.rooms import REPOSITORY, Room

_SLOWER = 8.0
"""Times that tests may take longer than their processor time before a mutant counts as one that hangs."""
_START = 60.0
"""Time that pytest may take to begin [s]."""


@dataclass(frozen=True)
class Outcome:
    """What the tests said of a mutant."""

    mutant: Mutant
    result: str
    """`failed`, `hung`, `survived`, or `not run` where no test runs its line."""
    said: str
    """Test that failed first."""
    seconds: float

    @property
    def is_killed(self) -> bool:
        """Tell whether a test noticed."""
        return self.result in ("failed", "hung")

    def __str__(self) -> str:
        mutant = self.mutant
        told = f"{self.result:8} {mutant.module}:{mutant.line} {mutant.operator} {mutant.text[:60]}"
        return f"{told} ({self.said})" if self.said else told


@dataclass(frozen=True, kw_only=True)
class Workplace:
    """A copy of the repository that is mutated, and what is known of its tests."""

    copy: Path
    room: Room
    lines: Mapping[str, Mapping[str, list[str]]]
    """Files of tests by module and line."""
    times: Mapping[str, float]
    """Processor time of each file of tests [s]."""
    digests: Mapping[str, str]
    """Digest of each file of tests as it was when it was watched."""

    @classmethod
    def prepare(cls, copy: Path, room: Room, rooms: Sequence[Room], kept: Path) -> "Workplace":
        """Copy the repository's files as they are, and watch the tests of a room unless `kept` has it for this code.

        Of all `rooms`, those with the same tests are watched at once.
        """
        _copy_repository(copy)
        watched = [each for each in rooms if each.tests == room.tests]
        code = {module: _digest(module) for each in watched for module in each.modules()}
        found = json.loads(read_text(kept)) if kept.exists() else {}
        if found.get("code") != code:
            print(f"running the tests of {', '.join(room.tests)} to see which lines they run", flush=True)
            files, place = room.test_files(), kept.with_suffix(".tmp").absolute()
            folders = ",".join(folder for each in watched for folder in each.code)
            command = ["-m", "scripts.mutation.watch", str(place), folders, *files]
            done = subprocess.run([sys.executable, *command], cwd=copy, env=_environment(copy))
            if done.returncode:
                raise FFGymError(
                    f"The tests of the room do not pass without a mutant: pytest ended with {done.returncode}."
                )
            found = json.loads(read_text(place)) | {"code": code, "tests": {file: _digest(file) for file in files}}
            write_json(kept, found)
            place.unlink()
        return cls(copy=copy, room=room, lines=found["lines"], times=found["times"], digests=found["tests"])

    def files_for(self, mutant: Mutant, limit: float) -> list[str]:
        """Files of tests that are asked: new and changed ones, then the fastest that run the line, up to a time [s].

        Lines that run when the module is imported are those of every file that runs any of it.
        """
        by_line = self.lines.get(mutant.module, {})
        names = set(by_line.get(str(mutant.line), ())) - {""}
        if not names:
            names = {name for each in by_line.values() for name in each} - {""}
        changed = [file for file in self.room.test_files() if self.digests.get(file) != _digest(file)]
        chosen, spent = changed, 0.0
        for file in sorted(names - set(changed), key=lambda file: self.times.get(file, 0.0)):
            spent += self.times.get(file, 0.0)
            if spent > limit and chosen:
                break
            chosen = [*chosen, file]
        return chosen

    def test(self, mutant: Mutant, limit: float) -> Outcome:
        """Run the tests with a mutant in place of its module."""
        files, place, began = self.files_for(mutant, limit), self.copy / mutant.module, time.perf_counter()
        if not files:
            return Outcome(mutant, "not run", "", 0.0)
        place.write_text(mutant.code(), encoding="utf-8")
        command = [sys.executable, "-m", "pytest", "-x", "-q", "--tb=no", "-p", "no:cacheprovider", *files]
        patience = _START + _SLOWER * max(limit, sum(self.times.get(file, 0.0) for file in files))
        try:
            done = subprocess.run(
                command, cwd=self.copy, env=_environment(self.copy), capture_output=True, text=True, timeout=patience
            )
            failures = [line for line in done.stdout.splitlines() if line.startswith(("FAILED", "ERROR"))]
            said = failures[0].partition(" ")[2].partition(" - ")[0] if failures else ""
            result = "failed" if done.returncode else "survived"
        except subprocess.TimeoutExpired:
            result, said = "hung", ""
        finally:
            shutil.copyfile(REPOSITORY / mutant.module, place)
        return Outcome(mutant, result, said, time.perf_counter() - began)


def _digest(file: str) -> str:
    """Digest of a file of the repository."""
    return hashlib.sha256((REPOSITORY / file).read_bytes()).hexdigest()[:16]


def _environment(copy: Path) -> dict[str, Any]:
    """Environment that imports the copy; a compiled module would outlive a mutant of the same size and second."""
    own = {"PYTHONPATH": str(copy.absolute()), "PYTHONDONTWRITEBYTECODE": "1", "OMP_NUM_THREADS": "1"}
    return {**os.environ, **own}


def _copy_repository(copy: Path) -> None:
    """Copy all files that git tracks or would track, where they differ."""
    command = ["git", "ls-files", "--cached", "--others", "--exclude-standard"]
    listed = subprocess.run(command, cwd=REPOSITORY, capture_output=True, text=True, check=True).stdout.splitlines()
    for name in listed:
        source, target = REPOSITORY / name, copy / name
        if source.is_symlink():
            target.parent.mkdir(parents=True, exist_ok=True)
            if not target.is_symlink():
                target.symlink_to(os.readlink(source))
        elif source.is_file() and not (target.exists() and target.read_bytes() == source.read_bytes()):
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(source, target)
