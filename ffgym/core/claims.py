"""Places that one process writes at a time: files, folders that are filled, and folders that are made.

A claim is a locked file beside a file or a new folder, or in a folder that is filled, and says who made it. It is
removed when the work ends. If the process is killed the lock ends with it, and the next claim of a place there removes
the file. On Windows and on drives without locks nothing is refused.
"""

import hashlib
import json
import os
import shlex
import socket
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from contextvars import ContextVar
from pathlib import Path

from ffgym.core.errors import FFGymError
from ffgym.core.temporaries import TEMPORARY, LockedError, lock, own, remove, remove_remains

_CLAIM = TEMPORARY.format("claim{}")
"""Name of the file of a claim."""

_LONGEST = 100
"""Characters of the command that a refusal quotes."""

_held: ContextVar[frozenset[Path]] = ContextVar("held", default=frozenset())
"""Files of the claims of the present work, in which a claim of a place that it has is no other claim."""

_work: ContextVar[ExitStack | None] = ContextVar("work", default=None)
"""Claims that last until the present piece of work ends."""


@contextmanager
def claimed(folder: str | os.PathLike[str]) -> Iterator[Path]:
    """Hold a folder, so that two processes do not fill it at once; what killed processes left half-written is removed.

    Raises:
        FFGymError: if another process holds the folder, or it cannot be read or written.
    """
    place = Path(folder)
    if not os.access(place, os.W_OK):
        raise FFGymError(f"{place}: is not writable; choose another folder, or allow writing.")
    with _hold(Path(os.path.realpath(place)) / _CLAIM.format(""), place):
        yield place


@contextmanager
def claimed_place(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Hold the place of a file or a folder that is to be written, whose folder must exist.

    Raises:
        FFGymError: if another process holds the place, or its folder cannot be read or written.
    """
    target = Path(os.path.realpath(path))  # through a link, as what is written there
    name = hashlib.sha256(target.name.encode(errors="surrogateescape")).hexdigest()[:16]
    with _hold(target.with_name(_CLAIM.format(f"-{name}")), Path(path)):
        yield Path(path)


@contextmanager
def piece_of_work() -> Iterator[None]:
    """Keep what `claim` claims until the block ends."""
    with ExitStack() as claims:
        before = _work.set(claims)
        try:
            yield
        finally:
            _work.reset(before)


def claim(path: str | os.PathLike[str]) -> None:
    """Hold the place of a file or folder, as `claimed_place`, until the present piece of work ends, if there is one."""
    if (claims := _work.get()) is not None:
        claims.enter_context(claimed_place(path))


@contextmanager
def _hold(file: Path, place: Path) -> Iterator[None]:
    """Hold a claim by its file; within a claim of the same work nothing is done."""
    if file in _held.get():
        yield
        return
    descriptor = _lock(file, place)
    before = _held.set(_held.get() | {file})
    try:
        remove_remains(file.parent)
        yield
    finally:
        _held.reset(before)
        remove(file)
        if descriptor is not None:
            os.close(descriptor)


def _lock(file: Path, place: Path) -> int | None:
    """Make and lock the file of a claim, and write into it who holds it."""
    try:
        for _ in range(100):  # the file may be removed between the first line and the second
            file.touch()
            with suppress(LockedError):
                descriptor = lock(file)
                own.add(file)
                file.write_text(json.dumps(_describe_process()), encoding="utf-8")
                return descriptor
            if (holder := _read_holder(file)) is not None:
                break
            time.sleep(0.01)
    except OSError as error:
        raise FFGymError(
            f"{place}: cannot be written: {error.strerror}; choose another place, or allow reading and writing there."
        ) from error
    raise FFGymError(
        f"{place}: {holder or 'another process'} is writing there. Wait for it, end it, or choose another place."
    )


def _describe_process() -> dict[str, str | int]:
    program = Path(sys.argv[0] if sys.argv else "")
    words = [program.parent.name if program.name == "__main__.py" else program.name, *sys.argv[1:]]
    return {"pid": os.getpid(), "host": socket.gethostname(), "command": shlex.join(words)}


def _read_holder(file: Path) -> str | None:
    """Name the process that holds a claim; None while it has not yet written so."""
    try:
        told = json.loads(file.read_text(encoding="utf-8"))
        there = "" if told["host"] == socket.gethostname() else f" on {told['host']}"
        command = " ".join(str(told["command"]).split())
    except (OSError, ValueError, KeyError, TypeError):
        return None
    shown = command if len(command) <= _LONGEST else f"{command[: _LONGEST - 3]}..."
    return f"process {told['pid']}{there} ({shown})"
