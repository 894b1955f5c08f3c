"""Watch over a process that reads damaged files: ended where it takes too long, begun again where it has died."""

import json
import os
import selectors
import shutil
import signal
import subprocess
import sys
import tempfile
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from ffgym.core.errors import FFGymError
from scripts.fuzz.outcome import Outcome

LIMIT = 20.0
"""Time that one input may take [s]."""
_BEGIN = 120.0
"""Time for imports and valid files, before the first input of a reader [s]."""
_FAST = "/dev/shm"
"""Folder in memory, where there is one: millions of files are written, and none is kept."""


class Watched:
    """Process for the readers of a module."""

    def __init__(self, module: str, limit: float = LIMIT) -> None:
        """Prepare; the process begins with the first input."""
        self._module, self._limit = module, limit
        self._root = Path(tempfile.mkdtemp(prefix="fuzz-", dir=_FAST if os.access(_FAST, os.W_OK) else None))
        self._process: subprocess.Popen[str] | None = None
        self._known: set[str] = set()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._end()
        shutil.rmtree(self._root, ignore_errors=True)

    def read(self, reader: str, seed: int, number: int) -> Outcome:
        """Let one input be read; the same process reads the next one, unless this one ends it.

        Raises:
            FFGymError: if the valid files of the reader cannot be made or read.
        """
        if reader not in self._known:
            if self._ask([reader, seed, None], _BEGIN) is None:
                raise FFGymError(f"The valid files of reader {reader} cannot be made or read: {self._end()}")
            self._known.add(reader)
        line = self._ask([reader, seed, number], self._limit)
        if line:
            found = Outcome(**json.loads(line))
            if found.kind == "memory":  # a process is told apart by the most that it ever held
                self._end()
            return found
        said = self._end()
        if line == "":
            return Outcome(kind="hang", detail=f"no answer after {self._limit:g} s", seconds=self._limit)
        return Outcome(kind="crash", detail=said)

    def _ask(self, request: list[Any], limit: float) -> str | None:
        """Send a request, and return the answer: empty if it does not come in time, None if the process ends."""
        process = self._process or self._begin()
        assert process.stdin is not None
        assert process.stdout is not None
        try:
            process.stdin.write(json.dumps(request) + "\n")
            process.stdin.flush()
        except BrokenPipeError:
            return None
        with selectors.DefaultSelector() as selector:
            selector.register(process.stdout, selectors.EVENT_READ)
            if not selector.select(limit):
                return ""
        return process.stdout.readline() or None

    def _begin(self) -> "subprocess.Popen[str]":
        environment = os.environ | {
            "OMP_NUM_THREADS": "1",
            "ARROW_DEFAULT_MEMORY_POOL": "system",
            "MALLOC_ARENA_MAX": "2",
            "PYTHONUNBUFFERED": "",  # as readers run elsewhere
        }
        self._known = set()
        self._process = subprocess.Popen(
            [sys.executable, "-m", "scripts.fuzz.worker", str(self._root), self._module],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env=environment,
        )
        return self._process

    def _end(self) -> str:
        """End the process; return how it ended, with the last that it printed."""
        if self._process is None:
            return ""
        process, self._process = self._process, None
        for stream in (process.stdin, process.stdout):
            if stream is not None:
                with suppress(BrokenPipeError):
                    stream.close()
        try:
            code = process.wait(timeout=1.0)
        except subprocess.TimeoutExpired:
            process.kill()
            code = process.wait()
        printed = self._root / "printed"
        said = printed.read_text(encoding="utf-8", errors="replace")[-400:] if printed.exists() else ""
        return f"{signal.Signals(-code).name if code < 0 else f'exit status {code}'}: {said}"
