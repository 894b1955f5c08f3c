"""Readers that do what none may do, each in another way."""

import os
import signal
import sys
import time
import warnings
from pathlib import Path

import numpy as np

from ffgym.core.errors import FFGymError
from scripts.fuzz.reader import Reader

GOOD = "good"
"""Text that all of them read without a fault."""


def make(folder: Path) -> Path:
    """Write the one valid file."""
    (folder / "file.txt").write_text(GOOD, encoding="utf-8")
    return folder / "file.txt"


def bad(name: str, fault) -> Reader:
    """A reader with a fault on all but the first call, which gets the valid file."""
    calls: list[Path] = []

    def use(path: Path) -> None:
        calls.append(path)
        if len(calls) > 1:
            fault()

    return Reader(name=name, use=use, makes=(make,), covers=())


def refuse() -> None:
    raise FFGymError("This is no good file. Write another one.")


def fail() -> None:
    raise KeyError("nothing")


def say_nothing() -> None:
    raise FFGymError(" ")


def warn() -> None:
    warnings.warn("it may be wrong", RuntimeWarning, stacklevel=1)


def leave_a_file() -> None:
    Path("MUJOCO_LOG.TXT").write_text("warning", encoding="utf-8")


def die() -> None:
    os.kill(os.getpid(), signal.SIGSEGV)


def sleep() -> None:
    time.sleep(100.0)


READERS = (
    bad("error", refuse),
    bad("exception", fail),
    bad("unclear", say_nothing),
    bad("warning", warn),
    bad("output", lambda: print("look here")),
    bad("output_of_the_engine", lambda: os.write(2, b"warning: look here")),
    bad("output_in_a_file", leave_a_file),
    bad("memory", lambda: np.ones(10**12)),
    bad("crash", die),
    bad("crash_by_exit", lambda: os._exit(3)),
    bad("hang", sleep),
    bad("exit", lambda: sys.exit(0)),
)
