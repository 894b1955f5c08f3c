"""Expressions with their types, known before a program runs, and their values, computed when it runs."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from ffgym.core.errors import FFGymError, errors_at
from ffgym.paths.rapid import syntax
from ffgym.paths.rapid.operators import Operate, check_size, find_operator
from ffgym.paths.rapid.records import ANY, BOOL, NUM, SIGNAL, STRING, Type, Value
from ffgym.paths.rapid.scope import CallFrame, DatumPart, DatumReference, Meaning, Unreadable

if TYPE_CHECKING:
    from ffgym.paths.rapid.linker import Scope


@dataclass(frozen=True)
class Typed:
    """An expression whose names and types are right."""

    type: Type
    value: Callable[[CallFrame], Value]
    fixed: bool
    """True if its value depends on no data of the program that may change."""
    asks: bool = False
    """True if its value depends on inputs of the controller."""


def link_expression(scope: "Scope", expression: syntax.Expression, wanted: Type) -> Typed:
    """Find the names and types of an expression.

    Raises:
        FFGymError: if one is unknown, or the expression is not of the type that is wanted; it begins with the place.
    """
    if isinstance(expression, syntax.Aggregate):
        return _link_aggregate(scope, expression, wanted)
    if wanted == SIGNAL and isinstance(expression, syntax.VariableReference):
        return _link_signal(scope, expression)
    if wanted == ANY and isinstance(expression, syntax.VariableReference) and scope.find(expression.name) is None:
        name = expression.name  # a unit, a task or a signal of the controller
        return Typed(ANY, lambda frame: Symbol(name), fixed=True)
    found = _link_natural(scope, expression)
    if found.type == SIGNAL and wanted == NUM:
        return _ask(scope, found)
    if not wanted.takes(found.type):
        raise expression.place.error(f"{wanted} is wanted here, this is {found.type}.")
    return found


class Symbol(str):
    """Name of something that only the controller knows."""


def _link_natural(scope: "Scope", expression: syntax.Expression) -> Typed:
    """Link an expression that has a type of its own."""
    if isinstance(expression, syntax.VariableReference):
        return _link_variable(scope, expression)
    if isinstance(expression, syntax.Call):
        return scope.link_function(expression)
    if isinstance(expression, syntax.OperatorChain):
        return _link_chain(scope, expression)
    if isinstance(expression, syntax.Negation):
        operand = link_expression(scope, expression.operand, BOOL)
        return replace(operand, value=lambda frame: not operand.value(frame))
    if isinstance(expression, syntax.SignedOperand):
        return _link_signed(scope, expression)
    if isinstance(expression, syntax.Literal):
        value = expression.value
        if isinstance(value, float):
            with errors_at(str(expression.place)):
                check_size(value)
        kind = BOOL if isinstance(value, bool) else STRING if isinstance(value, str) else NUM
        return Typed(kind, lambda frame: value, fixed=True)
    if isinstance(expression, syntax.Missing):
        raise Unreadable("value")
    raise expression.place.error("an aggregate has no type of its own here; assign it to data first.")


def _link_signed(scope: "Scope", expression: syntax.SignedOperand) -> Typed:
    operand = _link_natural(scope, expression.operand)
    if operand.type.name == "pos" and not operand.type.dimensions:
        turned = operand.value
        return replace(operand, value=lambda frame: tuple(-x if expression.negative else x for x in turned(frame)))
    operand = link_expression(scope, expression.operand, NUM)
    return replace(operand, value=lambda frame: -operand.value(frame) if expression.negative else operand.value(frame))


def _link_aggregate(scope: "Scope", expression: syntax.Aggregate, wanted: Type) -> Typed:
    """Link components by the types of their fields, or elements by the type of the array."""
    count = len(expression.items)
    if (wanted.loose and not wanted.dimensions) or wanted == ANY:
        items = [_link_loose_item(scope, item) for item in expression.items]
    elif wanted.dimensions:
        if wanted.dimensions[0] not in (0, count):
            raise expression.place.error(f"{wanted} has {wanted.dimensions[0]} elements, got {count}.")
        items = [link_expression(scope, item, wanted.element) for item in expression.items]
    elif not wanted.fields:
        raise expression.place.error(f"{wanted} is wanted here, this is an aggregate.")
    elif count != len(wanted.fields):
        raise expression.place.error(f"{wanted} has {len(wanted.fields)} components, {wanted.shape}, got {count}.")
    else:
        items = [
            link_expression(scope, item, kind) for item, (_, kind) in zip(expression.items, wanted.fields, strict=True)
        ]
    values = [item.value for item in items]
    kind = replace(wanted, dimensions=(count, *wanted.dimensions[1:])) if wanted.dimensions else wanted
    return Typed(
        kind,
        lambda frame: tuple([value(frame) for value in values]),
        fixed=all(item.fixed for item in items),
        asks=any(item.asks for item in items),
    )


def _link_loose_item(scope: "Scope", item: syntax.Expression) -> Typed:
    return _link_aggregate(scope, item, ANY) if isinstance(item, syntax.Aggregate) else _link_natural(scope, item)


def _link_signal(scope: "Scope", reference: syntax.VariableReference) -> Typed:
    """Link a signal: data of a signal type, or a name that only the controller knows."""
    if scope.find(reference.name) is not None:
        found = _link_variable(scope, reference)
        if found.type != SIGNAL:
            raise reference.place.error(f"a signal is wanted here, this is {found.type}.")
        return found
    name = reference.name
    return Typed(SIGNAL, lambda frame: name, fixed=True)


def _ask(scope: "Scope", signal: Typed) -> Typed:
    """Link the value of a signal."""
    ask = scope.controller.signals.ask
    return Typed(NUM, lambda frame: ask(signal.value(frame)), fixed=signal.fixed, asks=True)


def _link_chain(scope: "Scope", chain: syntax.OperatorChain) -> Typed:
    first = link_operand(scope, chain.first, chain.rest[0][0])
    kind, parts = first.type, [first]
    steps: list[tuple[Operate, Callable[[CallFrame], Value], syntax.SourceLocation]] = []
    for sign, expression in chain.rest:
        if isinstance(expression, syntax.Aggregate):
            right = link_expression(scope, expression, kind)
        else:
            right = link_operand(scope, expression, sign)
        with errors_at(str(expression.place)):
            kind, operate = find_operator(sign, kind, right.type)
        steps.append((operate, right.value, expression.place))
        parts.append(right)

    def value(frame: CallFrame) -> Value:
        result = first.value(frame)
        for operate, right, place in steps:
            operand = right(frame)
            try:
                result = operate(result, operand)
            except ZeroDivisionError:
                raise place.error("division by zero.") from None
            except FFGymError as error:
                raise place.error(str(error)) from None
        return result

    return Typed(kind, value, all(part.fixed for part in parts), any(part.asks for part in parts))


def link_operand(scope: "Scope", expression: syntax.Expression, sign: str = "=") -> Typed:
    """Link an operand; a signal stands for its value, and next to a comparison an unknown name for a signal."""
    if sign in ("=", "<>") and isinstance(expression, syntax.VariableReference) and scope.find(expression.name) is None:
        return _ask(scope, _link_signal(scope, expression))
    found = _link_natural(scope, expression)
    return _ask(scope, found) if found.type == SIGNAL else found


def _link_variable(scope: "Scope", reference: syntax.VariableReference) -> Typed:
    kind, find, meaning, fixed = _follow(scope, reference)
    place = reference.place

    def value(frame: CallFrame) -> Value:
        found = find(frame)
        if found is None:
            raise place.error(f"{reference.name} is not present in this call; ask with Present({reference.name}).")
        return found.get()

    return Typed(kind, value, fixed and meaning.kind == "CONST")


@dataclass(frozen=True)
class Changeable:
    """Data of a program, or a part of them, that may be changed."""

    type: Type
    find: Callable[[CallFrame], DatumReference]


def link_changeable(scope: "Scope", expression: syntax.Expression) -> Changeable:
    """Find data that are to be changed.

    Raises:
        FFGymError: if they are unknown or constant; it begins with the place.
    """
    if not isinstance(expression, syntax.VariableReference):
        raise expression.place.error("data that can be changed are wanted here; declare them as VAR or PERS.")
    kind, find, meaning, _ = _follow(scope, expression)
    name, place = expression.name, expression.place
    if not meaning.changeable:
        if meaning.kind == "FOR":
            raise place.error(f"{name} is the counter of a loop; use other data.")
        raise place.error(f"{name} is constant; declare it as VAR or PERS.")

    def found(frame: CallFrame) -> DatumReference:
        reference = find(frame)
        if reference is None:
            raise place.error(f"{name} is not present in this call; ask with Present({name}).")
        return reference

    return Changeable(kind, found)


def _follow(
    scope: "Scope", reference: syntax.VariableReference
) -> tuple[Type, Callable[[CallFrame], DatumReference | None], Meaning, bool]:
    """Type of data or of a part of them, what finds them in a frame, their meaning, and if it is always one part."""
    meaning = scope.find(reference.name)
    if meaning is None:
        raise scope.unknown(reference)
    kind, fixed = meaning.type, True
    path: list[Callable[[CallFrame, Value], int]] = []
    for part in reference.parts:
        if isinstance(part, syntax.Indices):
            if len(part.items) != len(kind.dimensions):
                raise reference.place.error(
                    f"{reference.name} has {len(kind.dimensions)} dimensions, got {len(part.items)} indices."
                )
            for item in part.items:
                index = link_expression(scope, item, NUM)
                fixed = fixed and index.fixed
                path.append(_index(index, kind.dimensions[0], item.place))
                kind = kind.element
        else:
            number = kind.field(part)
            if number < 0 or kind.dimensions:
                raise reference.place.error(f"{kind} has no component {part}, it is {kind.shape}.")
            path.append(_component(number))
            kind = kind.fields[number][1]
    if not path:
        return kind, meaning.find, meaning, fixed

    def find(frame: CallFrame) -> DatumReference | None:
        whole = meaning.find(frame)
        if whole is None:
            return None
        value, indices = whole.get(), []
        for step in path:
            indices.append(step(frame, value))
            value = value[indices[-1]]
        return DatumPart(whole, tuple(indices))

    return kind, find, meaning, fixed


def _component(number: int) -> Callable[[CallFrame, Value], int]:
    return lambda frame, record: number


def _index(index: Typed, size: int, place: syntax.SourceLocation) -> Callable[[CallFrame, Value], int]:
    """Return a function that computes an index from 0, and checks it against the array."""

    def compute(frame: CallFrame, array: Value) -> int:
        number = index.value(frame)
        if number != round(number) or not 1 <= number <= len(array):
            raise place.error(f"index {number:g} is out of range, must be a whole number from 1 to {len(array)}.")
        return round(number) - 1

    return compute
