"""Values of expressions, by the data in scope, checked against the type that is wanted."""

import operator
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import scipy

from ffgym.core.errors import FFGymError, errors_at
from ffgym.paths.rapid import syntax
from ffgym.paths.rapid.records import BOOL, NUM, PREDEFINED, ROBTARGET, STRING, TYPES, Type, Value
from ffgym.paths.rapid.targets import turn


@dataclass(frozen=True)
class ArgumentRule:
    """A required argument, and the optional ones that may follow it."""

    name: str
    type: Type
    options: Mapping[str, Type | None] = field(default_factory=dict)
    """Type by name in lower case; None for a switch, which has no value."""


@dataclass
class Datum:
    """A named value that may change."""

    kind: str
    """CONST, PERS or VAR."""
    type: Type
    value: Value


@dataclass
class Scope:
    """Scope: meaning of names at a statement."""

    module: dict[str, Datum] = field(default_factory=dict)
    local: dict[str, Datum] = field(default_factory=dict)

    def find(self, name: str) -> Datum | None:
        """Datum of that name, the nearest first; None if there is none."""
        key = name.lower()
        own = self.local.get(key, self.module.get(key))
        return Datum("CONST", *PREDEFINED[key]) if own is None and key in PREDEFINED else own

    def get(self, reference: syntax.VariableReference) -> tuple[Type, Value]:
        """Type and value of a datum or of one of its components."""
        datum = self._found(reference)
        kind, value = datum.type, datum.value
        for index in self._path(reference, datum):
            kind, value = kind.fields[index][1], value[index]
        return kind, value

    def type_of(self, reference: syntax.VariableReference) -> Type:
        """Type of a datum or component that is to be changed."""
        datum = self._found(reference)
        if datum.kind == "CONST":
            raise reference.place.error(f"{reference.parts[0]} is constant; declare it as VAR or PERS.")
        return self.get(reference)[0]

    def set(self, reference: syntax.VariableReference, value: Value) -> None:
        """Change a datum or one of its components."""
        datum = self._found(reference)
        datum.value = _replace(datum.value, self._path(reference, datum), value)

    def _found(self, reference: syntax.VariableReference) -> Datum:
        datum = self.find(reference.parts[0])
        if datum is None:
            raise reference.place.error(f"{reference.parts[0]} is not declared; declare it above, in this file.")
        return datum

    def _path(self, reference: syntax.VariableReference, datum: Datum) -> list[int]:
        """Indices of the components that a reference walks through."""
        path, kind = [], datum.type
        for part in reference.parts[1:]:
            index = kind.field(part)
            if index < 0:
                raise reference.place.error(f"{kind.name} has no component {part}, it is {kind.shape}.")
            path.append(index)
            kind = kind.fields[index][1]
        return path


def _replace(value: Value, path: list[int], new: Value) -> Value:
    """Copy a value with one component replaced."""
    if not path:
        return new
    changed = _replace(value[path[0]], path[1:], new)
    return (*value[: path[0]], changed, *value[path[0] + 1 :])


def find_type(declaration: syntax.Declaration) -> Type:
    """Find the type of a declaration."""
    kind = TYPES.get(declaration.type_name.lower())
    if kind is None:
        raise declaration.place.error(
            f"{declaration.name} has type {declaration.type_name}, which is not supported. Available: "
            f"{', '.join(sorted(TYPES))}."
        )
    return kind


def check_unique(names: Iterable[syntax.Declaration | syntax.Procedure]) -> None:
    """Refuse a name that is declared twice, whatever its case."""
    seen: dict[str, syntax.SourceLocation] = {}
    for named in names:
        first = seen.setdefault(named.name.lower(), named.place)
        if first is not named.place:
            raise named.place.error(f"{named.name} is declared twice, first at {first}.")


Options = Mapping[str, Value]
"""Values of optional arguments by name in lower case."""


def _offs(values: Sequence[Value], options: Options) -> Value:
    """Target displaced in the axes of the work object."""
    (position, *rest), *offset = values
    return (tuple(a + b for a, b in zip(position, offset, strict=True)), *rest)


def _rel_tool(values: Sequence[Value], options: Options) -> Value:
    """Target displaced in the axes of the tool, then turned about its x, its new y and its new z."""
    (position, orient, *rest), *offset = values
    tool = turn(orient, "the target's rot")
    angles = [options.get(name, 0.0) for name in ("rx", "ry", "rz")]
    rotation = scipy.spatial.transform.Rotation
    turned = rotation.from_matrix(tool) * rotation.from_euler("XYZ", angles, degrees=True)
    moved = np.array(position) + tool @ np.array(offset)
    q2, q3, q4, q1 = turned.as_quat().tolist()
    return (tuple(moved.tolist()), (q1, q2, q3, q4), *rest)


@dataclass(frozen=True)
class BuiltinFunction:
    """A function that displaces a target: what it takes, and what it computes."""

    parameters: tuple[ArgumentRule, ...]
    compute: Callable[[Sequence[Value], Options], Value]


_TARGET = ArgumentRule("target", ROBTARGET)

FUNCTIONS: Mapping[str, BuiltinFunction] = {
    "offs": BuiltinFunction((_TARGET, *(ArgumentRule(f"{axis}Offset", NUM) for axis in "XYZ")), _offs),
    "reltool": BuiltinFunction(
        (
            _TARGET,
            ArgumentRule("Dx", NUM),
            ArgumentRule("Dy", NUM),
            ArgumentRule("Dz", NUM, dict.fromkeys(("rx", "ry", "rz"), NUM)),
        ),
        _rel_tool,
    ),
}
"""Functions by name in lower case; RAPID reference manual (ABB 3HAC16581-1), functions Offs and RelTool."""


_OPERATIONS: Mapping[str, Callable[[float, float], float]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
}

LARGEST_NUMBER = 1e38
"""Bound on every number; RAPID's num is an IEEE 754 float of 32 bit, which ends at 3.4e38."""


def evaluate(scope: Scope, expression: syntax.Expression, wanted: Type) -> Value:
    """Value of an expression."""
    # aggregate: each component by the type of its field
    if isinstance(expression, syntax.Aggregate):
        if not wanted.fields:
            raise expression.place.error(f"{wanted.name} is wanted here, this is an aggregate.")
        if len(expression.items) != len(wanted.fields):
            raise expression.place.error(
                f"{wanted.name} has {len(wanted.fields)} components, {wanted.shape}, got {len(expression.items)}."
            )
        return tuple(
            evaluate(scope, item, kind) for item, (_, kind) in zip(expression.items, wanted.fields, strict=True)
        )
    # other expressions have a type of their own, which must be the wanted one
    if isinstance(expression, syntax.VariableReference):
        found, value = scope.get(expression)
    elif isinstance(expression, syntax.Call):
        function = FUNCTIONS.get(expression.name.lower())
        if function is None:
            raise expression.place.error(f"function {expression.name} is not supported. Available: Offs, RelTool.")
        values, options = arguments_of(scope, expression, function.parameters)
        with errors_at(str(expression.place)):
            found, value = ROBTARGET, function.compute(values, options)
    elif isinstance(expression, syntax.Literal) and not isinstance(expression.value, float):
        found, value = BOOL if isinstance(expression.value, bool) else STRING, expression.value
    else:
        found, value = NUM, _number(scope, expression)
    if found != wanted:
        raise expression.place.error(f"{wanted.name} is wanted here, this is {found.name}.")
    return value


def arguments_of(scope: Scope, call: syntax.Call, parameters: Sequence[ArgumentRule]) -> tuple[list[Value], Options]:
    """Values of the required arguments of a call, and of the optional ones by name; a switch that is on is True."""
    arguments, name = call.arguments, call.name
    if len(arguments) == len(parameters) + 1 and arguments[0].value is None:
        raise _reject_option(name, arguments[0].options[0], {})  # e.g. MoveL \Conc, p10, ...
    if len(arguments) != len(parameters):
        names = ", ".join(parameter.name for parameter in parameters)
        raise call.place.error(f"the arguments of {name} are ({names}), got {len(arguments)} of {len(parameters)}.")
    required: list[tuple[syntax.Expression, Type]] = []
    optional: dict[str, tuple[syntax.Expression | None, Type]] = {}
    # options by name, each once, with or without a value as declared
    for argument, parameter in zip(arguments, parameters, strict=True):
        for option in argument.options:
            if option.name.lower() not in parameter.options:
                raise _reject_option(f"the {parameter.name} of {name}", option, parameter.options)
            kind = parameter.options[option.name.lower()]  # None for a switch
            if option.name.lower() in optional:
                raise option.place.error(f"\\{option.name} is given twice.")
            if (option.value is None) != (kind is None):
                wanted = "takes no value" if kind is None else "needs a value, ':=' and what it is to be"
                raise option.place.error(f"\\{option.name} {wanted}.")
            optional[option.name.lower()] = (option.value, kind or BOOL)
        if argument.value is None:
            raise argument.options[0].place.error(f"the {parameter.name} of {name} is missing.")
        required.append((argument.value, parameter.type))
    # values last, when the shape of the call is known to be right
    values = [evaluate(scope, value, kind) for value, kind in required]
    return values, {
        key: True if value is None else evaluate(scope, value, kind) for key, (value, kind) in optional.items()
    }


def _reject_option(what: str, option: syntax.Option, known: Mapping[str, Type | None]) -> FFGymError:
    names = ", ".join("\\" + name for name in known)
    available = f"Available there: {names}" if known else "Leave it out"
    return option.place.error(f"\\{option.name} is not supported with {what}. {available}.")


def declare(scope: Scope, declaration: syntax.Declaration) -> Datum:
    """Datum that a declaration makes."""
    kind = find_type(declaration)
    if declaration.value is not None:
        return Datum(declaration.kind, kind, evaluate(scope, declaration.value, kind))
    if declaration.kind == "VAR":
        return Datum(declaration.kind, kind, kind.default())
    raise declaration.place.error(f"{declaration.kind} {declaration.name} needs a value, ':= ...'.")


def _number(scope: Scope, expression: syntax.Literal | syntax.Signed | syntax.OperatorChain) -> float:
    """Value of a literal, a signed operand, or a chain of operations."""
    if isinstance(expression, syntax.Literal):
        value = float(expression.value)
    elif isinstance(expression, syntax.Signed):
        value = evaluate(scope, expression.operand, NUM) * (-1 if expression.negative else 1)
    else:
        value = evaluate(scope, expression.first, NUM)
        for sign, operand in expression.rest:
            right = evaluate(scope, operand, NUM)
            if sign == "/" and right == 0:
                raise operand.place.error("division by zero.")
            value = _OPERATIONS[sign](value, right)
    if not abs(value) <= LARGEST_NUMBER:
        raise expression.place.error(f"{value:g} is too large, numbers go to {LARGEST_NUMBER:g}.")
    return value
