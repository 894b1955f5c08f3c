"""Data of a running program, and what a name means at a statement."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol

from ffgym.core.errors import FFGymError
from ffgym.paths.rapid.records import Type, Value
from ffgym.paths.rapid.syntax import SourceLocation

if TYPE_CHECKING:
    from ffgym.paths.rapid.loops import Loop


class DatumReference(Protocol):
    """Place of a value that may change."""

    def get(self) -> Value:
        """Value at present."""

    def set(self, value: Value) -> None:
        """Give it another value."""


@dataclass
class Datum:
    """A named value that may change."""

    value: Value

    def get(self) -> Value:
        """Value at present."""
        return self.value

    def set(self, value: Value) -> None:
        """Give it another value."""
        self.value = value


@dataclass(frozen=True)
class DatumPart:
    """A component of a record or an element of an array."""

    whole: DatumReference
    path: tuple[int, ...]

    def get(self) -> Value:
        """Value at present."""
        value = self.whole.get()
        for index in self.path:
            value = value[index]
        return value

    def set(self, value: Value) -> None:
        """Give it another value."""
        self.whole.set(_replace(self.whole.get(), self.path, value))


def _replace(value: Value, path: Sequence[int], new: Value) -> Value:
    """Copy a value with one part replaced."""
    if not path:
        return new
    changed = _replace(value[path[0]], path[1:], new)
    return (*value[: path[0]], changed, *value[path[0] + 1 :])


class CallFrame(list[DatumReference | None]):
    """Data of a call of a routine: parameters, its own data and counters of its loops; None for an absent parameter."""

    def __init__(self, data: Iterable[DatumReference | None] = ()) -> None:
        super().__init__(data)
        self.loops: dict[SourceLocation, Loop] = {}
        """Loops by GOTO that this call is in, by the place of the GOTO."""


@dataclass(frozen=True)
class Meaning:
    """Meaning of a name: data of the module, or data of the routine that is running."""

    type: Type
    kind: str
    """CONST, PERS or VAR; FOR for the counter of a loop, and IN for a parameter that is a value."""
    find: Callable[[CallFrame], DatumReference | None]
    optional: bool = False
    """True for a parameter that may be absent."""

    @property
    def changeable(self) -> bool:
        """True if a program may change it."""
        return self.kind not in ("CONST", "FOR")


def at_index(index: int) -> Callable[[CallFrame], DatumReference | None]:
    """Return a function that finds data at an index of a frame."""
    return lambda frame: frame[index]


@dataclass
class LocalScope:
    """Names of a routine, the newest last, and the size of its frames."""

    meanings: dict[str, Meaning] = field(default_factory=dict)
    size: int = 0

    def add(self, name: str, kind: Type, word: str, *, optional: bool = False) -> int:
        """Add a name; return the index of its data in a frame."""
        index = self.size
        self.meanings[name.lower()] = Meaning(kind, word, at_index(index), optional)
        self.size += 1
        return index


class Unreadable(FFGymError):
    """A name that may be declared where a file could not be read; no news beside the error about that."""


@dataclass
class ErrorList:
    """Errors of a program, each once."""

    errors: list[FFGymError] = field(default_factory=list)
    _known: set[str] = field(default_factory=set)

    def add(self, error: FFGymError) -> None:
        """Add an error, unless there is one with its message."""
        if not isinstance(error, Unreadable) and str(error) not in self._known:
            self._known.add(str(error))
            self.errors.append(error)

    def check(self) -> None:
        """Raise all errors as one, if there are any."""
        if self.errors:
            raise join_errors(self.errors)


MOST_LISTED = 30
"""Most errors that one message lists; chosen: a screen full."""


def join_errors(errors: Sequence[FFGymError]) -> FFGymError:
    """One error that lists all, a line each, those of a file in its order."""
    if len(errors) == 1:
        return errors[0]
    lines = sorted((str(error) for error in errors), key=_order)[:MOST_LISTED]
    if len(errors) > MOST_LISTED:
        lines.append(f"... and {len(errors) - MOST_LISTED} more errors")
    return FFGymError("\n".join(lines))


def _order(line: str) -> tuple[str, int, int]:
    """Sort key of an error: its file, line and column."""
    file, *numbers = line.split(":", 3)[:3]
    row, column = (int(number) if number.isdigit() else 0 for number in (*numbers, "", "")[:2])
    return file, row, column
