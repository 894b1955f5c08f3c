"""Contents of a file of another tool: named arrays, as they are, before anything is said about their meaning."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ffgym.core.errors import FFGymError
from ffgym.recordings.schema import alike, short

NUMBERS = "biuf"
"""NumPy kinds that are real numbers."""

TEXT = "US"
"""NumPy kinds that are text."""

_LISTED = 12
"""Arrays that a message lists; `ffgym log columns` lists all."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Contents:
    """Arrays of a file by name. Nothing is converted; shapes are those of the file."""

    where: str
    """Path of the file, for messages."""
    arrays: Mapping[str, NDArray[Any]]
    """Name -> numbers or text of any shape."""
    streams: Mapping[str, str] = field(default_factory=dict)
    """Name -> the stream it came with, where a file holds several with clocks of their own (the topics of a bag)."""
    clocks: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    """Stream -> kind of clock ('stamp', 'log_time') -> name of the array with its times."""
    skipped: Mapping[str, str] = field(default_factory=dict)
    """Name -> why what the file holds under it cannot be read as an array."""

    def __iter__(self) -> Iterator[str]:
        return iter(self.arrays)

    def __getitem__(self, name: str) -> NDArray[Any]:
        """Array of that name.

        Raises:
            FFGymError: if there is none; the message says what there is.
        """
        if name in self.arrays:
            return self.arrays[name]
        if name in self.skipped:
            raise FFGymError(f"{name!r} cannot be read: {self.skipped[name]}.")
        similar = alike(name, map(readable, self.arrays))
        raise FFGymError(
            f"There is no {name!r} in the file. {f'{similar} ' if similar else ''}It holds {self.summary()}."
        )

    def numbers(self, name: str) -> NDArray[Any]:
        """Array of that name, of real numbers.

        Raises:
            FFGymError: if there is none, or it is text or complex.
        """
        array = self[name]
        if array.dtype.kind in NUMBERS:
            return array
        if array.dtype.kind in TEXT:
            raise FFGymError(
                f"{name!r} is not numbers: {_first_text(array)}. For a text file, decimal, units_row and first_row in "
                "[file] of the column map say how its cells are to be read."
            )
        raise FFGymError(f"{name!r} is {array.dtype}, must be real numbers.")

    def summary(self) -> str:
        """Names and shapes of the first arrays, on one line."""
        shown = [f"{readable(name)} {array.shape}" for name, array in list(self.arrays.items())[:_LISTED]]
        rest = len(self.arrays) - len(shown)
        return (", ".join(shown) or "nothing") + (f" and {rest} more; `ffgym log columns` lists all" if rest else "")


def readable(name: str) -> str:
    """Name of an array for a line of text: those of damaged files may be long, or hold line ends."""
    return short(name if name.isprintable() else repr(name))


def _first_text(array: NDArray[Any]) -> str:
    """Find the first entry that is no number, and say its place and its text."""
    for index, cell in np.ndenumerate(array):
        try:
            number = float(cell) if "_" not in str(cell) else None  # which float skips
        except ValueError:
            number = None
        if number is None:
            place = index[0] if len(index) == 1 else index
            return f"row {place} is {str(cell)[:40]!r}" if index else f"it is {str(cell)[:40]!r}"
    return "it is text"
