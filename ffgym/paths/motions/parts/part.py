"""One part of a motion file: a kind, and entries that say what it means and in which unit."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import MISSING, Field, dataclass, field, fields
from typing import Any, ClassVar, Self

from ffgym.core.errors import FFGymError
from ffgym.paths.motions.parts.place import Place
from ffgym.paths.moves import Move


def entry(meaning: str, unit: str = "", **options: Any) -> Any:
    """Field of a part, with what the documentation says about it; `default` makes it optional."""
    return field(metadata={"meaning": meaning, "unit": unit}, **options)


@dataclass(frozen=True, kw_only=True, eq=False)
class Part(ABC):
    """A part of a motion, as it stands in a file."""

    kind: ClassVar[str]
    """What the file calls it."""

    label: str = entry("name of the part, for phases and messages", default="")

    @abstractmethod
    def moves(self, place: Place) -> Sequence[Move]:
        """Moves that carry out the part with a robot.

        Raises:
            FFGymError: if an entry makes no sense for it.
        """

    @classmethod
    def parse(cls, table: Mapping[str, Any]) -> Self:
        """Part with the entries of a table.

        Raises:
            FFGymError: if an entry is missing or unknown.
        """
        known = {f.name: f for f in entries(cls)}
        unknown = sorted(set(table) - set(known))
        if unknown:
            raise FFGymError(f"Unknown entries {', '.join(unknown)}. A {cls.kind} has {', '.join(known)}.")
        missing = [name for name, f in known.items() if is_required(f) and name not in table]
        if missing:
            raise FFGymError(f"Missing entries: {', '.join(missing)}. A {cls.kind} needs them.")
        if not isinstance(table.get("label", ""), str):
            raise FFGymError(f"label = {table['label']!r} must be text.")
        return cls(**table)


def entries(part: type[Part]) -> tuple[Field[Any], ...]:
    """Entries of a kind of part, those that are required first."""
    return tuple(sorted(fields(part), key=lambda f: not is_required(f)))


def is_required(f: Field[Any]) -> bool:
    """Whether a file must say it."""
    return f.default is MISSING and f.default_factory is MISSING
