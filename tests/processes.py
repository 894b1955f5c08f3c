"""Processes of tests that outlive what they should, or not."""

import signal
import time
from contextlib import contextmanager
from contextvars import Context
from functools import partial
from pathlib import Path

from ffgym.core.claims import claimed

INTERRUPTIBLE = partial(signal.signal, signal.SIGINT, signal.SIG_DFL)
"""What a process does first (preexec_fn) so that SIGINT reaches it: jobs in the background of a shell ignore it."""


def is_alive(pid):
    stat = Path(f"/proc/{pid}/stat")
    try:
        return stat.read_text().rpartition(")")[2].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False


def waited(condition, limit=30.0):
    end = time.monotonic() + limit
    while time.monotonic() < end:
        found = condition()
        if found:
            return found
        time.sleep(0.05)
    return condition()


@contextmanager
def held_elsewhere(folder):
    """Hold a folder as another process does: by a claim that the work of this one does not know."""
    elsewhere, claim = Context(), claimed(folder)
    elsewhere.run(claim.__enter__)
    try:
        yield
    finally:
        elsewhere.run(claim.__exit__, None, None, None)
