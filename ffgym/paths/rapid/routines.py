"""Routines of a program: their parameters, calls of them, and the built-in functions that are called alike."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ffgym.core.errors import FFGymError, errors_at
from ffgym.paths.rapid import syntax
from ffgym.paths.rapid.arguments import check_option, check_readable, link_arguments
from ffgym.paths.rapid.expressions import Typed, link_changeable, link_expression
from ffgym.paths.rapid.functions import FUNCTIONS, BuiltinFunction
from ffgym.paths.rapid.geometry import GEOMETRY
from ffgym.paths.rapid.records import BOOL, Type, Value
from ffgym.paths.rapid.scope import CallFrame, Datum, DatumReference

if TYPE_CHECKING:
    from ffgym.paths.rapid.linker import Scope
    from ffgym.paths.rapid.statements import Block

MAX_CALLS = 40
"""Deepest nesting of calls; chosen: programs need ten, and Python's stack must not end."""

BUILTIN: Mapping[str, BuiltinFunction] = {
    name.lower(): function for name, function in {**FUNCTIONS, **GEOMETRY}.items()
}
"""Functions of RAPID by name in lower case."""


class Returned(Exception):
    """A routine has come to RETURN."""

    def __init__(self, value: Value) -> None:
        super().__init__()
        self.value = value


@dataclass(frozen=True)
class LinkedParameter:
    """Parameter of a routine with its type."""

    name: str
    type: Type
    changes: bool
    """True if data of the caller are wanted, which the routine may change."""
    optional: bool
    switch: bool


class LinkedRoutine:
    """A routine whose statements are linked when it is first called for."""

    def __init__(self, routine: syntax.Routine, scope: "Scope") -> None:
        self.routine = routine
        self.scope = scope
        self._head: list[LinkedParameter] | None = None
        self._block: Block | None = None
        self._data: list[tuple[int, Callable[[CallFrame], Value]]] = []
        self._calls = 0

    @property
    def parameters(self) -> list[LinkedParameter]:
        """Parameters in their order, which come first in the frame."""
        if self._head is None:
            self._head = [self._parameter(parameter) for parameter in self.routine.parameters]
        return self._head

    def _parameter(self, parameter: syntax.RoutineParameter) -> LinkedParameter:
        switch = parameter.type_name.lower() == "switch"
        kind = BOOL if switch else self.scope.type_of(parameter.type_name, parameter.place)
        if parameter.dimensions:
            kind = Type(kind.name, kind.fields, (0,) * parameter.dimensions, kind.loose)
        if parameter.name.lower() in self.scope.local.meanings:
            raise parameter.place.error(f"{parameter.name} is declared twice.")
        # what is passed as a value may be changed as well, which the caller does not see
        self.scope.local.add(parameter.name, kind, parameter.mode or "IN", optional=parameter.optional)
        return LinkedParameter(parameter.name, kind, bool(parameter.mode), parameter.optional, switch)

    def link(self) -> None:
        """Link all statements; errors go to the controller."""
        from ffgym.paths.rapid.statements import link_block

        if self._block is not None:
            return
        _ = self.parameters
        for declaration in self.routine.declarations:
            try:
                self._declare(declaration)
            except FFGymError as error:
                self.scope.controller.errors.add(error)
        self._block = link_block(self.scope, self.routine.statements, self.routine)

    def _declare(self, declaration: syntax.Declaration) -> None:
        if declaration.kind == "PERS":
            raise declaration.place.error(
                f"{declaration.name} is PERS in a routine; declare it in the module, or as VAR."
            )
        if declaration.name.lower() in self.scope.local.meanings:
            raise declaration.place.error(f"{declaration.name} is declared twice in {self.routine.name}.")
        kind, value = self.scope.declare(declaration)
        self._data.append((self.scope.local.add(declaration.name, kind, declaration.kind), value))

    def run(self, arguments: list[DatumReference | None], place: syntax.SourceLocation) -> Value:
        """Run the routine with references for its parameters; the value of a function."""
        self.link()
        assert self._block is not None
        if self._calls >= MAX_CALLS:
            raise place.error(f"{self.routine.name} calls itself more than {MAX_CALLS} deep, it must come to an end.")
        frame = CallFrame([*arguments, *([None] * (self.scope.local.size - len(arguments)))])
        for index, value in self._data:
            frame[index] = Datum(value(frame))
        self._calls += 1
        try:
            self._block.run(frame)
        except Returned as returned:
            return returned.value
        except RecursionError:
            raise place.error(f"calls are nested too deep at {self.routine.name}.") from None
        finally:
            self._calls -= 1
        if self.routine.kind == "FUNC":
            raise self.routine.place.error(f"function {self.routine.name} ends without RETURN.")
        return None


Bind = Callable[[CallFrame], "list[DatumReference | None]"]


def link_call(scope: "Scope", call: syntax.Call, routine: LinkedRoutine) -> tuple[Bind, list[Typed]]:
    """Link the arguments of a call of a routine; return what binds them, and those that have a value."""
    check_readable(call)
    parameters = routine.parameters
    required = [parameter for parameter in parameters if not parameter.optional]
    if len(call.values) != len(required):
        names = ", ".join(parameter.name for parameter in required)
        raise call.place.error(
            f"the arguments of {routine.routine.name} are ({names}), got {len(call.values)} of {len(required)}."
        )
    known = {p.name.lower(): None if p.switch else p.type for p in parameters if p.optional}
    options: dict[str, syntax.Option] = {}
    for given in call.options:
        check_option(call.name, given, known, options)
        options[given.name.lower()] = given
    values = iter(call.values)
    binds: list[Callable[[CallFrame], DatumReference | None]] = []
    parts: list[Typed] = []
    for parameter in parameters:
        option = options.get(parameter.name.lower())
        if not parameter.optional:
            binds.append(_bind(scope, next(values), parameter, parts))
        elif option is None:
            binds.append(lambda frame: None)
        elif option.value is None:
            binds.append(lambda frame: Datum(True))
        else:
            binds.append(_bind_option(scope, option.value, parameter, parts, option.passed_on))
    return lambda frame: [bind(frame) for bind in binds], parts


def _bind(
    scope: "Scope", expression: syntax.Expression, parameter: LinkedParameter, parts: list[Typed]
) -> Callable[[CallFrame], DatumReference | None]:
    """Return a function that makes the reference of a parameter: to data of the caller, or to a value of its own."""
    if parameter.changes:
        data = link_changeable(scope, expression)
        if not parameter.type.takes(data.type):
            raise expression.place.error(f"{parameter.type} is wanted here, this is {data.type}.")
        parts.append(Typed(data.type, data.find, fixed=False))
        return data.find
    typed = link_expression(scope, expression, parameter.type)
    parts.append(typed)
    return lambda frame: Datum(typed.value(frame))


def _bind_option(
    scope: "Scope", expression: syntax.Expression, parameter: LinkedParameter, parts: list[Typed], passed_on: bool
) -> Callable[[CallFrame], DatumReference | None]:
    r"""Return a function that makes the reference of an optional parameter; `\a?b` gives it if b is present."""
    if not passed_on:
        return _bind(scope, expression, parameter, parts)
    assert isinstance(expression, syntax.VariableReference)
    meaning = scope.find(expression.name)
    if meaning is None:
        raise scope.unknown(expression)
    return meaning.find


def link_function(scope: "Scope", call: syntax.Call) -> Typed:
    """Link a call of a function: one of the program, or one of RAPID."""
    routine = scope.find_routine(call.name)
    if routine is not None:
        return _own_function(scope, call, routine)
    if call.name.lower() == "present":
        return _present(scope, call)
    function = BUILTIN.get(call.name.lower())
    if function is None:
        names = ", ".join(sorted([*FUNCTIONS, *GEOMETRY, "Present"]))
        raise call.place.error(f"function {call.name} is not supported, and none of this program. Available: {names}.")
    linked = link_arguments(scope, call, function.rule)
    controller = scope.controller

    def value(frame: CallFrame) -> Value:
        values, options = linked.values(frame), linked.options(frame)
        with errors_at(str(call.place)):
            return function.compute(controller, values, options)

    asks = any(part.asks for part in linked.parts) or call.name.lower() in _ASKING
    fixed = all(part.fixed for part in linked.parts) and (function.fixed or asks)
    return Typed(function.result, value, fixed, asks)


_ASKING = frozenset(("dinput", "ginput", "ainput", "testdi"))
"""Functions that ask for inputs, in lower case."""


def _own_function(scope: "Scope", call: syntax.Call, routine: LinkedRoutine) -> Typed:
    if routine.routine.kind != "FUNC":
        raise call.place.error(f"{call.name} is a {routine.routine.kind}, which has no value.")
    bind, _ = link_call(scope, call, routine)
    kind = routine.scope.type_of(routine.routine.type_name, routine.routine.place)
    scope.program.reach(routine)
    return Typed(kind, lambda frame: routine.run(bind(frame), call.place), fixed=False)


def _present(scope: "Scope", call: syntax.Call) -> Typed:
    """Present: whether an optional parameter was given."""
    if len(call.values) != 1 or not isinstance(call.values[0], syntax.VariableReference):
        raise call.place.error("Present wants the name of an optional parameter.")
    meaning = scope.find(call.values[0].name)
    if meaning is None or not meaning.optional:
        raise call.place.error(f"Present wants an optional parameter, {call.values[0].name} is none.")
    return Typed(BOOL, lambda frame: meaning.find(frame) is not None, fixed=True)
