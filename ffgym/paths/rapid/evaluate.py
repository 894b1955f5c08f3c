"""Values of expressions, checked against the type that is wanted."""

import operator
from collections.abc import Callable, Mapping, Sequence

from ffgym.core.errors import FFGymError
from ffgym.paths.rapid.arguments import Paired, Parameter, pair
from ffgym.paths.rapid.functions import FUNCTIONS, Options
from ffgym.paths.rapid.records import BOOL, NUM, STRING, Type, Value
from ffgym.paths.rapid.scope import Datum, Scope, declared_type
from ffgym.paths.rapid.syntax import (
    Aggregate,
    Call,
    Chain,
    Declaration,
    Expression,
    Number,
    Reference,
    Signed,
    Text,
    Truth,
)

_OPERATIONS: Mapping[str, Callable[[float, float], float]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
}

LARGEST_NUMBER = 1e38
"""Bound on every number; RAPID's num is an IEEE 754 float of 32 bit, which ends at 3.4e38."""


def evaluate(scope: Scope, expression: Expression, wanted: Type) -> Value:
    """Value of an expression.

    Raises:
        FFGymError: if it is not of type `wanted`, names something unknown, or is no finite number.
    """
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
    """Datum that a declaration makes.

    Raises:
        FFGymError: if its type is unknown, or its value does not fit.
    """
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
    try:
        return function.result, function.compute(values, options)
    except FFGymError as error:
        raise scope.source.error(call.place, str(error)) from error


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
