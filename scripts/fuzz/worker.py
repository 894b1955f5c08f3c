"""Process that reads damaged files: `python -m scripts.fuzz.worker FOLDER MODULE`, a line of JSON for each one.

It gives its answers on the standard output that it began with; whatever is printed meanwhile goes to a file, and is a
finding. Its memory is limited, so that what asks for too much fails.
"""

import json
import os
import resource
import shutil
import sys
import time
from dataclasses import asdict, replace
from importlib import import_module
from pathlib import Path

from scripts.fuzz.outcome import VALID, Outcome, judge
from scripts.fuzz.places import remove
from scripts.fuzz.reader import Reader, damage, make_valid

MEMORY = 2 * 2**30
"""Memory that one input may take [byte], above that of what is imported."""


def main() -> None:
    """Answer until the input ends; a request is a line of JSON: reader, seed, number, or none to prepare the reader."""
    root, module = Path(sys.argv[1]), sys.argv[2]
    answers = os.fdopen(os.dup(1), "w")
    printed = os.open(root / "printed", os.O_RDWR | os.O_CREAT | os.O_APPEND)
    os.dup2(printed, 1)
    os.dup2(printed, 2)
    found: dict[str, Reader] = {one.name: one for one in import_module(module).READERS}
    tables: dict[str, Table] = {}
    for line in sys.stdin:
        name, seed, number = json.loads(line)
        if name not in tables:
            resource.setrlimit(resource.RLIMIT_AS, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
            tables[name] = Table(found[name], root, printed)
            _limit_memory()
        answer = {} if number is None else asdict(tables[name].read(seed, number))
        answers.write(json.dumps(answer) + "\n")
        answers.flush()


class Table:
    """Valid files of a reader in folders, of which one is damaged while an input is read."""

    def __init__(self, reader: Reader, root: Path, printed: int) -> None:
        """Write the valid files and check that they are read, so that what is imported then counts for no input."""
        self._reader, self._printed = reader, printed
        self._here = root / "here"
        self._here.mkdir(exist_ok=True)
        os.chdir(self._here)
        self._valid = make_valid(reader, root / "made")
        self._folders = [root / f"{reader.name}-{k}" for k in range(len(self._valid))]
        for one, folder in zip(self._valid, self._folders, strict=True):
            shutil.rmtree(folder, ignore_errors=True)
            found = judge(reader.use, one.write(folder), reader.errors)
            if found.kind != VALID:
                raise RuntimeError(f"{reader.name}: {found}")
        sys.stdout.flush()
        os.truncate(printed, 0)
        self._peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024

    def read(self, seed: int, number: int) -> Outcome:
        """Damage a file, read it, and mend it."""
        hurt = damage(self._reader, self._valid, seed, number)
        one, folder = self._valid[hurt.number], self._folders[hurt.number]
        hurt.write(folder)
        start = time.perf_counter()
        found = judge(self._reader.use, folder / one.main, self._reader.errors)
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        found = replace(found, seconds=time.perf_counter() - start, peak_mb=peak)
        if (peak - self._peak) * 2**20 > MEMORY:  # beyond what the process had taken before
            found = replace(found, kind="memory", detail=f"{peak:.0f} MB; {found.kind}: {found.detail}"[:500])
        if not isinstance(hurt.data, bytes):
            remove(folder / hurt.name)
        (folder / hurt.name).write_bytes(one.files[hurt.name])
        return self._with_remains(found)

    def _with_remains(self, found: Outcome) -> Outcome:
        """Look for what was printed, or left where the process works."""
        sys.stdout.flush()
        size = os.fstat(self._printed).st_size
        if size:
            text = os.pread(self._printed, 500, 0).decode(errors="replace")
            os.truncate(self._printed, 0)
            found = replace(found, kind="output", detail=text) if found.is_right else found
        if left := os.listdir(self._here):
            for name in left:
                remove(self._here / name)
            found = replace(found, kind="output", detail=f"left {', '.join(left)}") if found.is_right else found
        return found


def _limit_memory() -> None:
    """Let the process have MEMORY beyond what it holds."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
    limit = pages * resource.getpagesize() + MEMORY
    resource.setrlimit(resource.RLIMIT_AS, (limit, resource.RLIM_INFINITY))


if __name__ == "__main__":
    main()
