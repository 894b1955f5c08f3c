"""Values of expressions, by the data in scope, checked against the type that is wanted."""

import operator
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation

from ffgym.core.errors import FFGymError, errors_at
from ffgym.paths.rapid.records import BOOL, NUM, PREDEFINED, ROBTARGET, STRING, TYPES, Type, Value
from ffgym.paths.rapid.syntax import (
    Aggregate,
    Argument,
    Call,
    Chain,
    Declaration,
    Expression,
    Number,
    Option,
    Place,
    Procedure,
    Reference,
    Signed,
    Source,
    Text,
    Truth,
)
from ffgym.paths.rapid.targets import turn


@dataclass(frozen=True)
class Parameter:
    """A required argument, and the optional ones that may follow it."""

    name: str
    type: Type
    options: Mapping[str, Type | None] = field(default_factory=dict)
    """Type by name in lower case; None for a switch, which has no value."""


@dataclass(frozen=True)
class Paired:
    """Arguments in the order of their parameters."""

    values: tuple[Expression, ...]
    options: Mapping[str, Option]
    """By name in lower case."""


def pair(
    source: Source, name: str, place: Place, arguments: Sequence[Argument], parameters: Sequence[Parameter]
) -> Paired:
    """Pair the arguments of `name` with its parameters.

    Raises:
        FFGymError: if there are too many or too few, or an option that is not supported there.
    """
    if len(arguments) == len(parameters) + 1 and arguments[0].value is None:
        raise _unsupported(source, name, arguments[0].options[0], {})  # e.g. MoveL \Conc, p10, ...
    if len(arguments) != len(parameters):
        names = ", ".join(parameter.name for parameter in parameters)
        raise source.error(place, f"the arguments of {name} are ({names}), got {len(arguments)} of {len(parameters)}.")
    values: list[Expression] = []
    options: dict[str, Option] = {}
    for argument, parameter in zip(arguments, parameters, strict=True):
        for option in argument.options:
            _add(source, name, option, parameter, options)
        if argument.value is None:
            raise source.error(argument.options[0].place, f"the {parameter.name} of {name} is missing.")
        values.append(argument.value)
    return Paired(tuple(values), options)


def _add(source: Source, name: str, option: Option, parameter: Parameter, options: dict[str, Option]) -> None:
    """Put an option with the others, if it may stand behind this parameter."""
    key = option.name.lower()
    if key not in parameter.options:
        raise _unsupported(source, f"the {parameter.name} of {name}", option, parameter.options)
    if key in options:
        raise source.error(option.place, f"\\{option.name} is given twice.")
    if (option.value is None) != (parameter.options[key] is None):
        wanted = "takes no value" if parameter.options[key] is None else "needs a value, ':=' and what it is to be"
        raise source.error(option.place, f"\\{option.name} {wanted}.")
    options[key] = option


def _unsupported(source: Source, what: str, option: Option, known: Mapping[str, Type | None]) -> FFGymError:
    names = ", ".join("\\" + name for name in known)
    available = f"Available there: {names}" if known else "Leave it out"
    return source.error(option.place, f"\\{option.name} is not supported with {what}. {available}.")


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
        """Type and value of a datum or of one of its components."""
        datum = self._found(reference)
        kind, value = datum.type, datum.value
        for index in self._path(reference, datum):
            kind, value = kind.fields[index][1], value[index]
        return kind, value

    def type_of(self, reference: Reference) -> Type:
        """Type of a datum or component that is to be changed."""
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
    """Type of a declaration."""
    kind = TYPES.get(declaration.type_name.lower())
    if kind is None:
        raise source.error(
            declaration.place,
            f"{declaration.name} has type {declaration.type_name}, which is not supported. Available: "
            f"{', '.join(sorted(TYPES))}.",
        )
    return kind


def check_unique(source: Source, names: Iterable[Declaration | Procedure]) -> None:
    """Refuse a name that is declared twice, whatever its case."""
    seen: dict[str, Place] = {}
    for named in names:
        first = seen.setdefault(named.name.lower(), named.place)
        if first is not named.place:
            raise source.error(named.place, f"{named.name} is declared twice, first at {source.at(first)}.")


Options = Mapping[str, Value]
"""Values of optional arguments by name in lower case."""


@dataclass(frozen=True)
class Function:
    """A function: what it takes, what it gives."""

    parameters: tuple[Parameter, ...]
    result: Type
    compute: Callable[[Sequence[Value], Options], Value]


def _offs(values: Sequence[Value], options: Options) -> Value:
    """Target displaced in the axes of the work object."""
    (position, *rest), *offset = values
    return (tuple(a + b for a, b in zip(position, offset, strict=True)), *rest)


def _rel_tool(values: Sequence[Value], options: Options) -> Value:
    """Target displaced in the axes of the tool, then turned about its x, its new y and its new z."""
    (position, orient, *rest), *offset = values
    tool = turn(orient, "the target's rot")
    angles = [options.get(name, 0.0) for name in ("rx", "ry", "rz")]
    turned = Rotation.from_matrix(tool) * Rotation.from_euler("XYZ", angles, degrees=True)
    moved = np.array(position) + tool @ np.array(offset)
    q2, q3, q4, q1 = turned.as_quat().tolist()
    return (tuple(moved.tolist()), (q1, q2, q3, q4), *rest)


_TARGET = Parameter("target", ROBTARGET)

FUNCTIONS: Mapping[str, Function] = {
    "offs": Function(
        (_TARGET, Parameter("XOffset", NUM), Parameter("YOffset", NUM), Parameter("ZOffset", NUM)), ROBTARGET, _offs
    ),
    "reltool": Function(
        (
            _TARGET,
            Parameter("Dx", NUM),
            Parameter("Dy", NUM),
            Parameter("Dz", NUM, {"rx": NUM, "ry": NUM, "rz": NUM}),
        ),
        ROBTARGET,
        _rel_tool,
    ),
}
"""By name in lower case; RAPID reference manual (ABB 3HAC16581-1), functions Offs and RelTool."""


_OPERATIONS: Mapping[str, Callable[[float, float], float]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
}

LARGEST_NUMBER = 1e38
"""Bound on every number; RAPID's num is an IEEE 754 float of 32 bit, which ends at 3.4e38."""


def evaluate(scope: Scope, expression: Expression, wanted: Type) -> Value:
    """Value of an expression."""
    if isinstance(expression, Aggregate):
        return _aggregate(scope, expression, wanted)
    if isinstance(expression, Reference):
        found, value = scope.get(expression)
    elif isinstance(expression, Call):
        found, value = _call(scope, expression)
    elif isinstance(expression, Text):
        found, value = STRING, expression.value
    elif isinstance(expression, Truth):
        found, value = BOOL, expression.value
    else:
        found, value = NUM, _number(scope, expression)
    if found != wanted:
        raise scope.source.error(expression.place, f"{wanted.name} is wanted here, this is {found.name}.")
    return value


def evaluate_arguments(scope: Scope, paired: Paired, parameters: Sequence[Parameter]) -> tuple[list[Value], Options]:
    """Values of required and of optional arguments, those by name in lower case; a switch that is on is True."""
    values = [evaluate(scope, e, p.type) for e, p in zip(paired.values, parameters, strict=True)]
    types = {name: kind for parameter in parameters for name, kind in parameter.options.items()}
    options = {
        name: True if option.value is None else evaluate(scope, option.value, types[name] or BOOL)
        for name, option in paired.options.items()
    }
    return values, options


def declare(scope: Scope, declaration: Declaration) -> Datum:
    """Datum that a declaration makes."""
    kind = declared_type(scope.source, declaration)
    if declaration.value is not None:
        return Datum(declaration.kind, kind, evaluate(scope, declaration.value, kind))
    if declaration.kind == "VAR":
        return Datum(declaration.kind, kind, kind.default())
    raise scope.source.error(declaration.place, f"{declaration.kind} {declaration.name} needs a value, ':= ...'.")


def _aggregate(scope: Scope, aggregate: Aggregate, wanted: Type) -> Value:
    if not wanted.fields:
        raise scope.source.error(aggregate.place, f"{wanted.name} is wanted here, this is an aggregate.")
    if len(aggregate.items) != len(wanted.fields):
        raise scope.source.error(
            aggregate.place,
            f"{wanted.name} has {len(wanted.fields)} components, {wanted.shape}, got {len(aggregate.items)}.",
        )
    return tuple(evaluate(scope, item, kind) for item, (_, kind) in zip(aggregate.items, wanted.fields, strict=True))


def _call(scope: Scope, call: Call) -> tuple[Type, Value]:
    function = FUNCTIONS.get(call.name.lower())
    if function is None:
        raise scope.source.error(call.place, f"function {call.name} is not supported. Available: Offs, RelTool.")
    paired = pair(scope.source, call.name, call.place, call.arguments, function.parameters)
    values, options = evaluate_arguments(scope, paired, function.parameters)
    with errors_at(scope.source.at(call.place)):
        value = function.compute(values, options)
    return function.result, value


def _number(scope: Scope, expression: Number | Signed | Chain) -> float:
    """Value of a literal, a signed operand, or a chain of operations."""
    if isinstance(expression, Number):
        value = expression.value
    elif isinstance(expression, Signed):
        value = evaluate(scope, expression.operand, NUM) * (-1 if expression.negative else 1)
    else:
        value = evaluate(scope, expression.first, NUM)
        for sign, operand in expression.rest:
            right = evaluate(scope, operand, NUM)
            if sign == "/" and right == 0:
                raise scope.source.error(operand.place, "division by zero.")
            value = _OPERATIONS[sign](value, right)
    if not abs(value) <= LARGEST_NUMBER:
        raise scope.source.error(expression.place, f"{value:g} is too large, numbers go to {LARGEST_NUMBER:g}.")
    return value
