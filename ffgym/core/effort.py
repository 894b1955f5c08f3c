"""Motions that are announced before they are planned or simulated, so that a command can say how long they take."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Literal

Stage = Literal["plan", "plan all", "run"]
"""What is about to begin: planning of one more motion, of all motions of a set, or the simulation of some."""

Watch = Callable[[float, Stage], None]
"""Function of the seconds of motion and their stage, which raises an error where the work is not to begin."""

_watch: ContextVar[Watch | None] = ContextVar("watch", default=None)


@contextmanager
def watched(watch: Watch) -> Iterator[None]:
    """Call a function before motions are planned or simulated in the block."""
    before = _watch.set(watch)
    try:
        yield
    finally:
        _watch.reset(before)


def announce(seconds: float, stage: Stage) -> None:
    """Announce motions that take some seconds on the robot, before work that grows with them."""
    if (watch := _watch.get()) is not None:
        watch(seconds, stage)
