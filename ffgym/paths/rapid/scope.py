"""Data of a program by name: the procedure's own, the module's, and what RAPID predefines."""

from collections.abc import Iterable
from dataclasses import dataclass, field

from ffgym.paths.rapid.predefined import PREDEFINED
from ffgym.paths.rapid.records import TYPES, Type, Value
from ffgym.paths.rapid.source import Source
from ffgym.paths.rapid.syntax import Declaration, Place, Procedure, Reference


@dataclass
class Datum:
    """A named value that may change."""

    kind: str
    """CONST, PERS or VAR."""
    type: Type
    value: Value


@dataclass
class Scope:
    """What names mean where a statement stands."""

    source: Source
    module: dict[str, Datum] = field(default_factory=dict)
    local: dict[str, Datum] = field(default_factory=dict)

    def find(self, name: str) -> Datum | None:
        """Datum of that name, the nearest first; None if there is none."""
        key = name.lower()
        if key in self.local:
            return self.local[key]
        if key in self.module:
            return self.module[key]
        return Datum("CONST", *PREDEFINED[key]) if key in PREDEFINED else None

    def get(self, reference: Reference) -> tuple[Type, Value]:
        """Type and value of a datum or of one of its components.

        Raises:
            FFGymError: if there is no such datum or component.
        """
        datum = self._found(reference)
        kind, value = datum.type, datum.value
        for index in self._path(reference, datum):
            kind, value = kind.fields[index][1], value[index]
        return kind, value

    def type_of(self, reference: Reference) -> Type:
        """Type of a datum or component that is to be changed.

        Raises:
            FFGymError: if there is no such datum or component, or it is constant.
        """
        datum = self._found(reference)
        if datum.kind == "CONST":
            raise self.source.error(reference.place, f"{reference.parts[0]} is constant; declare it as VAR or PERS.")
        return self.get(reference)[0]

    def set(self, reference: Reference, value: Value) -> None:
        """Change a datum or one of its components."""
        datum = self._found(reference)
        datum.value = _replaced(datum.value, self._path(reference, datum), value)

    def _found(self, reference: Reference) -> Datum:
        datum = self.find(reference.parts[0])
        if datum is None:
            raise self.source.error(
                reference.place, f"{reference.parts[0]} is not declared; declare it above, in this file."
            )
        return datum

    def _path(self, reference: Reference, datum: Datum) -> list[int]:
        """Indices of the components that a reference walks through."""
        path, kind = [], datum.type
        for part in reference.parts[1:]:
            index = kind.field(part)
            if index < 0:
                raise self.source.error(reference.place, f"{kind.name} has no component {part}, it is {kind.shape}.")
            path.append(index)
            kind = kind.fields[index][1]
        return path


def _replaced(value: Value, path: list[int], new: Value) -> Value:
    """A copy of a value with one component changed."""
    if not path:
        return new
    changed = _replaced(value[path[0]], path[1:], new)
    return (*value[: path[0]], changed, *value[path[0] + 1 :])


def declared_type(source: Source, declaration: Declaration) -> Type:
    """Type of a declaration.

    Raises:
        FFGymError: if there is none of that name.
    """
    kind = TYPES.get(declaration.type_name.lower())
    if kind is None:
        raise source.error(
            declaration.place,
            f"{declaration.name} has type {declaration.type_name}, which is not supported. Available: "
            f"{', '.join(sorted(TYPES))}.",
        )
    return kind


def check_unique(source: Source, names: Iterable[Declaration | Procedure]) -> None:
    """Refuse a name that is declared twice, whatever its case.

    Raises:
        FFGymError: at the second declaration.
    """
    seen: dict[str, Place] = {}
    for named in names:
        first = seen.setdefault(named.name.lower(), named.place)
        if first is not named.place:
            raise source.error(named.place, f"{named.name} is declared twice, first at {source.at(first)}.")
