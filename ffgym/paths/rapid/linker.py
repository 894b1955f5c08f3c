"""Names of a program: what each module declares, and what a name stands for at a statement."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace

from ffgym.core.errors import FFGymError
from ffgym.paths.rapid import syntax
from ffgym.paths.rapid.controller import RapidController
from ffgym.paths.rapid.expressions import Typed, link_expression
from ffgym.paths.rapid.predefined import PREDEFINED
from ffgym.paths.rapid.records import NUM, TYPES, Type, Value
from ffgym.paths.rapid.routines import LinkedRoutine, link_function
from ffgym.paths.rapid.scope import CallFrame, Datum, LocalScope, Meaning, Unreadable

LARGEST_ARRAY = 100_000
"""Most elements of an array; chosen: more than any program has, and memory must not run out."""


@dataclass
class ModuleNames:
    """Declarations of a module, or those that all modules share; by name in lower case."""

    declarations: dict[str, tuple[syntax.Declaration, "ModuleNames"]] = field(default_factory=dict)
    """Data, and the module whose names their values are written in."""
    routines: dict[str, LinkedRoutine] = field(default_factory=dict)
    records: dict[str, syntax.RecordDeclaration] = field(default_factory=dict)
    data: dict[str, Meaning] = field(default_factory=dict)
    """Data that were asked for."""


class LinkedProgram:
    """All modules of a program with one controller that runs it.

    Data get their values when they are first asked for, so that they may be declared in any order.
    """

    def __init__(
        self, modules: Sequence[syntax.Module], controller: RapidController, skipped: frozenset[str] = frozenset()
    ) -> None:
        self.controller = controller
        self.skipped = skipped
        """Names in lower case that may be declared where a file could not be read."""
        self.shared = ModuleNames()
        self.modules: list[tuple[syntax.Module, ModuleNames]] = []
        self._pending: list[str] = []
        self._reached: list[LinkedRoutine] = []
        for module in modules:
            own = ModuleNames()
            self.modules.append((module, own))
            _check_unique((*module.records, *module.declarations, *module.routines))
            for record in module.records:
                (own if record.local else self.shared).records[record.name.lower()] = record
            for declaration in module.declarations:
                self._share(own if declaration.local else self.shared, declaration, own)
            for routine in module.routines:
                names = own if routine.local else self.shared
                self._check_new(routine, names)
                names.routines[routine.name.lower()] = LinkedRoutine(routine, Scope(self, own, LocalScope()))

    def _share(self, names: ModuleNames, declaration: syntax.Declaration, own: ModuleNames) -> None:
        self._check_new(declaration, names)
        names.declarations[declaration.name.lower()] = (declaration, own)

    def _check_new(self, named: syntax.Declaration | syntax.Routine, names: ModuleNames) -> None:
        key = named.name.lower()
        first = names.declarations[key][0] if key in names.declarations else None
        other = names.routines[key].routine if key in names.routines else first
        if other is not None:
            raise named.place.error(f"{named.name} is declared twice, first at {other.place}.")

    def check_data(self) -> None:
        """Find values of all data of known types; errors go to the controller."""
        for _, own in self.modules:
            for names in (own, self.shared):
                for key, (declaration, home) in names.declarations.items():
                    if home is own and Scope(self, own, LocalScope()).find_type(declaration.type_name) is not None:
                        self._try_value(own, key)

    def _try_value(self, own: ModuleNames, key: str) -> None:
        try:
            self.find(own, key)
        except FFGymError as error:
            self.controller.errors.add(error)

    def find(self, own: ModuleNames, key: str) -> Meaning | None:
        """Meaning of the name of data in a module; None if there are none of that name."""
        for names in (own, self.shared):
            if key in names.data:
                return names.data[key]
            if key in names.declarations:
                declaration, home = names.declarations[key]
                names.data[key] = self._declare(declaration, home, key)
                return names.data[key]
        if key in PREDEFINED:
            kind, value = PREDEFINED[key]
            return _constant(kind, value)
        return None

    def _declare(self, declaration: syntax.Declaration, home: ModuleNames, key: str) -> Meaning:
        if key in self._pending:
            raise declaration.place.error(f"the value of {declaration.name} depends on itself.")
        self._pending.append(key)
        try:
            kind, value = Scope(self, home, LocalScope()).declare(declaration)
            datum = Datum(value(CallFrame()))
        finally:
            self._pending.pop()
        return Meaning(kind, declaration.kind, lambda frame: datum)

    def find_routine(self, own: ModuleNames, name: str) -> LinkedRoutine | None:
        """Find a routine by its name in a module."""
        key = name.lower()
        return own.routines.get(key, self.shared.routines.get(key))

    def find_linked(self, routine: syntax.Routine) -> LinkedRoutine:
        """Linked routine of one of the modules."""
        every = (one for names in (self.shared, *(own for _, own in self.modules)) for one in names.routines.values())
        return next(one for one in every if one.routine is routine)

    def reach(self, routine: LinkedRoutine) -> None:
        """Remember a routine that is called, to be linked."""
        self._reached.append(routine)

    def link_reached(self) -> None:
        """Link all routines that are called, and those that they call."""
        while self._reached:
            self._reached.pop().link()

    def state(self) -> tuple[Value, ...]:
        """Values of all data of the modules that were asked for, and of the signals."""
        data = [names.data[key] for names in (self.shared, *(own for _, own in self.modules)) for key in names.data]
        values = tuple(reference.get() for meaning in data if (reference := meaning.find(CallFrame())) is not None)
        return (values, tuple(self.controller.signals.values.items()))


def _constant(kind: Type, value: Value) -> Meaning:
    datum = Datum(value)
    return Meaning(kind, "CONST", lambda frame: datum)


def _check_unique(named: Iterable[syntax.Declaration | syntax.Routine | syntax.RecordDeclaration]) -> None:
    """Refuse a name that a module declares twice, whatever its case."""
    seen: dict[str, syntax.SourceLocation] = {}
    for one in named:
        first = seen.setdefault(one.name.lower(), one.place)
        if first is not one.place:
            raise one.place.error(f"{one.name} is declared twice, first at {first}.")


@dataclass
class Scope:
    """Meaning of names at a statement."""

    program: LinkedProgram
    module: ModuleNames
    local: LocalScope

    @property
    def controller(self) -> RapidController:
        """The controller that runs the program."""
        return self.program.controller

    def find(self, name: str) -> Meaning | None:
        """Meaning of the name of data, the nearest first; None if there are none."""
        key = name.lower()
        return self.local.meanings.get(key) or self.program.find(self.module, key)

    def unknown(self, reference: syntax.VariableReference) -> FFGymError:
        """Error about a name that stands for no data."""
        if reference.name.lower() in self.program.skipped:
            return Unreadable(reference.name)
        return reference.place.error(
            f"{reference.name} is not declared; declare it in this module or another one of the program."
        )

    def find_type(self, name: str) -> Type | None:
        """Find a type of RAPID or of the program."""
        key = name.lower()
        record = self.module.records.get(key, self.program.shared.records.get(key))
        if record is None:
            return TYPES.get(key)
        parts = [(part, self._component(kind, record)) for kind, part, _ in record.components]
        if [part for part, _ in parts] == [""]:  # another name for a type
            return parts[0][1]
        return Type(record.name.lower(), tuple(parts))

    def _component(self, name: str, record: syntax.RecordDeclaration) -> Type:
        if name.lower() == record.name.lower():
            raise record.place.error(f"record {record.name} contains itself.")
        return self.type_of(name, record.place)

    def type_of(self, name: str, place: syntax.SourceLocation) -> Type:
        """Type of a declaration.

        Raises:
            FFGymError: if there is none of that name.
        """
        kind = self.find_type(name)
        if kind is None:
            raise place.error(f"type {name} is not supported. Available: {', '.join(sorted(TYPES))}.")
        return kind

    def declare(self, declaration: syntax.Declaration) -> tuple[Type, Callable[[CallFrame], Value]]:
        """Type of a declaration, and the function that computes its first value."""
        element = self.type_of(declaration.type_name, declaration.place)
        sizes = tuple(self._size(item) for item in declaration.dimensions)
        kind, count = replace(element, dimensions=sizes), 1
        for size in sizes:
            count *= size
        if count > LARGEST_ARRAY or len(sizes) > 3:
            raise declaration.place.error(
                f"{declaration.name} has {len(sizes)} dimensions and {count} elements; arrays have 1 to 3 and at most "
                f"{LARGEST_ARRAY}."
            )
        if declaration.value is not None:
            return kind, link_expression(self, declaration.value, kind).value
        if declaration.kind == "VAR" or (declaration.kind == "PERS" and not kind.fields):
            default = kind.default()
            return kind, lambda frame: default
        raise declaration.place.error(f"{declaration.kind} {declaration.name} needs a value, ':= ...'.")

    def _size(self, expression: syntax.Expression) -> int:
        typed = link_expression(self, expression, NUM)
        if not typed.fixed:
            raise expression.place.error("the size of an array must be a constant.")
        size: float = typed.value(CallFrame())
        if size != round(size) or size < 1:
            raise expression.place.error(f"size {size:g} of an array must be a whole number >= 1.")
        return round(size)

    def link_function(self, call: syntax.Call) -> Typed:
        """Link a function of the program or of RAPID."""
        return link_function(self, call)

    def find_routine(self, name: str) -> LinkedRoutine | None:
        """Find a routine of the program."""
        return self.program.find_routine(self.module, name)
