"""What instructions and functions take, and arguments paired with it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from ffgym.core.errors import FFGymError
from ffgym.paths.rapid.records import Type
from ffgym.paths.rapid.source import Source
from ffgym.paths.rapid.syntax import Argument, Expression, Option, Place


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
