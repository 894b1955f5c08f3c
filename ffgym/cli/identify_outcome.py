"""What an identification gives to the command: words, entries of a parameter file, numbers, a page."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from ffgym.robot.reading.quantity import Quantity


@dataclass(frozen=True, kw_only=True, eq=False)
class Outcome:
    """One identification; every kind of it gives one to `ffgym identify`."""

    title: str
    """Of the parameter file."""
    text: str
    """For people."""
    quantities: Mapping[str, Quantity]
    """Entries of the parameter file."""
    numbers: Mapping[str, Any]
    """Everything, as JSON has it."""
    page: Callable[[Mapping[str, Any]], str]
    """Report page, for the origin of the numbers."""
