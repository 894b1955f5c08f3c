"""Arguments of functions and instructions of RAPID: linked before a program runs, evaluated when it runs."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from ffgym.core.errors import FFGymError
from ffgym.paths.rapid import syntax
from ffgym.paths.rapid.expressions import Symbol, Typed, link_changeable, link_expression
from ffgym.paths.rapid.functions import CallRule, Options, show_value
from ffgym.paths.rapid.records import ANY, BOOL, NUM, Type, Value
from ffgym.paths.rapid.scope import CallFrame, Unreadable

if TYPE_CHECKING:
    from ffgym.paths.rapid.linker import Scope


@dataclass(frozen=True)
class Invocation:
    """An instruction with the values of its arguments."""

    name: str
    """As it was written."""
    place: syntax.SourceLocation
    values: Sequence[Value]
    """Required arguments; references for data that it may change."""
    options: Options
    labels: Sequence[str]
    """What messages call each required argument."""
    places: Sequence[syntax.SourceLocation]
    """Where each required argument stands."""
    names: Mapping[str, str] = field(default_factory=dict)
    """Optional arguments as they were written, by name in lower case."""
    written: str = ""
    """The instruction as it was written, where its values are not to be told."""

    @property
    def text(self) -> str:
        """The instruction with its values, on one line."""
        if self.written:
            return self.written
        words = ", ".join(_tell(value, label) for value, label in zip(self.values, self.labels, strict=True))
        named = "".join(
            f"\\{self.names.get(key, key)}" + ("" if value is True else f":={_tell(value, '')}")
            for key, value in self.options.items()
        )
        return f"{self.name} {words}".rstrip() + named


def _tell(value: Value, label: str) -> str:
    """Tell the value of an argument: numbers and texts as they are, large data by their name."""
    if isinstance(value, str) and not isinstance(value, Symbol) and label != value:
        return f'"{value}"'
    return label if isinstance(value, tuple) or not isinstance(value, float | bool | str) else show_value(value)


@dataclass(frozen=True)
class Linked:
    """Arguments whose names and types are right."""

    required: tuple[Typed, ...]
    optional: Mapping[str, Typed | None]
    """By name in lower case; None for a switch."""
    labels: tuple[Callable[[CallFrame], str], ...]

    def values(self, frame: CallFrame) -> list[Value]:
        """Values of the required arguments."""
        return [argument.value(frame) for argument in self.required]

    def options(self, frame: CallFrame) -> dict[str, Value]:
        """Values of the optional arguments by name in lower case; True for a switch."""
        return {name: True if typed is None else typed.value(frame) for name, typed in self.optional.items()}

    @property
    def parts(self) -> list[Typed]:
        """All arguments that have a value."""
        return [*self.required, *(typed for typed in self.optional.values() if typed is not None)]


def link_arguments(scope: "Scope", call: syntax.Call, rule: CallRule) -> Linked:
    """Link the arguments of a call by what it takes.

    Raises:
        FFGymError: if they are not those; it begins with the place.
    """
    check_readable(call)
    count, names = len(call.values), [parameter.name for parameter in rule.parameters]
    least = len(names) if rule.least is None else rule.least
    if not least <= count <= len(names):
        wanted = f"{len(names)}" if least == len(names) else f"{least} to {len(names)}"
        raise call.place.error(f"the arguments of {call.name} are ({', '.join(names)}), got {count} of {wanted}.")
    optional: dict[str, Typed | None] = {}
    for option in call.options:
        check_option(call.name, option, rule.options, optional)
        kind = rule.options[option.name.lower()]
        if kind is None or option.value is None:
            optional[option.name.lower()] = None
        else:
            changes = option.name.lower() in rule.changed
            optional[option.name.lower()] = _link_one(scope, option.value, kind, changes=changes)
    required = [
        _link_one(scope, expression, parameter.type, changes=parameter.changes)
        for expression, parameter in zip(call.values, rule.parameters, strict=False)
    ]
    return Linked(tuple(required), optional, tuple(link_label(scope, expression) for expression in call.values))


def check_readable(call: syntax.Call) -> None:
    """Refuse a call with an argument that could not be read; there is an error about that already."""
    values = (*call.values, *(option.value for option in call.options))
    if any(isinstance(value, syntax.Missing) for value in values):
        raise Unreadable(call.name)


def _link_one(scope: "Scope", expression: syntax.Expression, kind: Type, *, changes: bool) -> Typed:
    """Link an argument: a value, or data that may be changed."""
    if not changes:
        return link_expression(scope, expression, kind)
    data = link_changeable(scope, expression)
    if not kind.takes(data.type):
        raise expression.place.error(f"{kind} is wanted here, this is {data.type}.")
    return Typed(data.type, data.find, fixed=False)


def link_anything(scope: "Scope", call: syntax.Call) -> Linked:
    """Link arguments of which nothing is known but that they must have a meaning."""
    required = tuple(link_expression(scope, value, ANY) for value in call.values)
    optional = {
        option.name.lower(): None if option.value is None else link_expression(scope, option.value, ANY)
        for option in call.options
    }
    return Linked(required, optional, tuple(link_label(scope, value) for value in call.values))


def check_option(
    name: str, option: syntax.Option, known: Mapping[str, Type | None], given: Mapping[str, object]
) -> None:
    """Refuse an option that is not known, given twice, or with a value where it has none."""
    key = option.name.lower()
    if key not in known:
        available = f"Available: {', '.join(chr(92) + option for option in known)}" if known else "Leave it out"
        raise option.place.error(f"\\{option.name} is not supported with {name}. {available}.")
    if key in given:
        raise option.place.error(f"\\{option.name} is given twice.")
    if (option.value is None) != (known[key] is None) and not option.passed_on:
        wanted = "takes no value" if known[key] is None else "needs a value, ':=' and what it is to be"
        raise option.place.error(f"\\{option.name} {wanted}.")


def link_label(scope: "Scope", expression: syntax.Expression) -> Callable[[CallFrame], str]:
    r"""Return a function that labels an argument for messages and phases, and a target by how it is displaced.

    These are names and numbers, e.g. 'Offs(p10, 0, -20\Rx:=5)', whatever was written for the numbers.
    """
    if isinstance(expression, syntax.VariableReference):
        return _label_data(scope, expression)
    if not isinstance(expression, syntax.Call):
        return lambda frame: "target"
    arguments = [(_label_argument(scope, value), "") for value in expression.values]
    for option in expression.options:
        label = (lambda frame: "") if option.value is None else _label_argument(scope, option.value)
        arguments.append((label, f"\\{option.name}" + ("" if option.value is None else ":=")))

    def label_of(frame: CallFrame) -> str:
        text = ""
        for label, option in arguments:
            text += option + label(frame) if option else f"{', ' if text else ''}{label(frame)}"
        return f"{expression.name}({text})"

    return label_of


def _label_data(scope: "Scope", reference: syntax.VariableReference) -> Callable[[CallFrame], str]:
    """Return a function that labels data by their names and the numbers of their indices."""
    steps: list[Callable[[CallFrame], str]] = [_label_word(reference.name)]
    for part in reference.parts:
        if isinstance(part, syntax.Indices):
            steps.append(_label_indices([link_expression(scope, item, NUM) for item in part.items]))
        else:
            steps.append(_label_word(f".{part}"))
    return lambda frame: "".join(step(frame) for step in steps)


def _label_word(text: str) -> Callable[[CallFrame], str]:
    return lambda frame: text


def _label_indices(indices: Sequence[Typed]) -> Callable[[CallFrame], str]:
    return lambda frame: "{" + ",".join(f"{index.value(frame):g}" for index in indices) + "}"


def _label_argument(scope: "Scope", expression: syntax.Expression) -> Callable[[CallFrame], str]:
    """Return a function that labels an argument of a function: a number by its value, a target by its own label."""
    try:
        number = link_expression(scope, expression, NUM)
    except FFGymError:
        return link_label(scope, expression)
    if number.type in (NUM, BOOL):
        return lambda frame: f"{number.value(frame) + 0.0:g}"
    return link_label(scope, expression)
