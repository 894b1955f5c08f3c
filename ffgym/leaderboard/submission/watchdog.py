"""A limit on how long something may take that cannot be interrupted but by ending it."""

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np

_LOOKS_EVERY = 0.05
"""[s]."""


class Watchdog:
    """Calls `kill` once when a block takes longer than its limit.

    Args:
        kill: called from a thread of its own.
    """

    def __init__(self, kill: Callable[[], None]) -> None:
        self.expired = False
        """Whether it has called."""
        self._kill, self._deadline = kill, np.inf
        self._stopped = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    @contextmanager
    def limit(self, seconds: float) -> Iterator[None]:
        """Block that may take so long [s]."""
        self._deadline = time.monotonic() + seconds
        try:
            yield
        finally:
            self._deadline = np.inf

    def stop(self) -> None:
        """End the thread."""
        self._stopped.set()
        self._thread.join()

    def _run(self) -> None:
        while not self._stopped.wait(_LOOKS_EVERY):
            if time.monotonic() > self._deadline:
                self.expired = True
                self._kill()
                return
