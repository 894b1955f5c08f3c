"""Functions of RAPID on numbers and texts."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from ffgym.core.errors import FFGymError, check_whole
from ffgym.paths.rapid.operators import check_size
from ffgym.paths.rapid.records import ANY, BOOL, NUM, POS, SIGNAL, STRING, Type, Value

if TYPE_CHECKING:
    from ffgym.paths.rapid.controller import RapidController

Options: TypeAlias = Mapping[str, Value]
"""Values of optional arguments by name in lower case; True for a switch."""

MOST_DIGITS = 15
"""Most digits behind the point; RAPID's dnum has no more."""

Compute: TypeAlias = "Callable[[RapidController, Sequence[Value], Options], Value]"


@dataclass(frozen=True)
class ArgumentRule:
    """Required argument of a function or an instruction."""

    name: str
    type: Type
    changes: bool = False
    """True if data are wanted that the instruction may change."""


@dataclass(frozen=True)
class CallRule:
    """Arguments that a function or an instruction takes."""

    parameters: tuple[ArgumentRule, ...] = ()
    options: Mapping[str, Type | None] = field(default_factory=dict)
    """Types of optional arguments by name in lower case; None for a switch, which has no value."""
    least: int | None = None
    """Required arguments at least; None if all of them."""
    changed: frozenset[str] = frozenset()
    """Optional arguments that are data which it may change."""


@dataclass(frozen=True)
class BuiltinFunction:
    """A function of RAPID: what it takes, gives and computes."""

    rule: CallRule
    result: Type
    compute: Compute
    fixed: bool = True
    """True if its value depends on its arguments alone."""


def takes(*types: Type, **options: Type | None) -> CallRule:
    """CallRule of required arguments of these types, and of optional ones by name in lower case."""
    return CallRule(tuple(ArgumentRule(f"argument {i}", kind) for i, kind in enumerate(types, start=1)), options)


def _make_numeric(compute: Callable[..., float], count: int = 1) -> BuiltinFunction:
    """Return a function of numbers that gives a number."""

    def compute_within(controller: "RapidController", values: Sequence[Value], options: Options) -> Value:
        try:
            return check_size(float(compute(*values)))
        except (ValueError, OverflowError, ZeroDivisionError):
            numbers = ", ".join(f"{value:g}" for value in values)
            raise FFGymError(f"there is no value for ({numbers}).") from None

    return BuiltinFunction(takes(*(NUM,) * count), NUM, compute_within)


def _make_rounding(rounding: Callable[[float], float]) -> BuiltinFunction:
    r"""Return a function that rounds a number to `\Dec` digits behind the point."""

    def compute(controller: "RapidController", values: Sequence[Value], options: Options) -> Value:
        scale = 10.0 ** check_whole("\\Dec", options.get("dec", 0.0), low=0, high=MOST_DIGITS)
        return float(rounding(values[0] * scale) / scale)

    return BuiltinFunction(takes(NUM, dec=NUM), NUM, compute)


def _round_half_away(value: float) -> float:
    return math.copysign(math.floor(abs(value) + 0.5), value)


def show_value(value: Value) -> str:
    """Show a value as RAPID writes it."""
    if isinstance(value, bool):
        return "TRUE" if value else "FALSE"
    if isinstance(value, float):
        return f"{value + 0.0:.6g}"
    if isinstance(value, tuple):
        return f"[{','.join(show_value(part) for part in value)}]"
    return str(value)


def _write_number(controller: "RapidController", values: Sequence[Value], options: Options) -> Value:
    number, digits = values
    return f"{number:.{check_whole('Dec', digits, low=0, high=MOST_DIGITS)}f}"


def _measure_dimension(controller: "RapidController", values: Sequence[Value], options: Options) -> Value:
    array, number = values
    for _ in range(check_whole("dimension", number, low=1, high=3) - 1):
        array = array[0] if isinstance(array, tuple) else None
    if not isinstance(array, tuple):
        raise FFGymError(f"the array has no dimension {number:g}.")
    return float(len(array))


def _cut_text(controller: "RapidController", values: Sequence[Value], options: Options) -> Value:
    text, first, count = values[0], int(values[1]), int(values[2])
    if not (first >= 1 and count >= 0 and first - 1 + count <= len(text)):
        raise FFGymError(f"{text!r} has no {count} characters from character {first} on.")
    return text[first - 1 : first - 1 + count]


def _ask(controller: "RapidController", values: Sequence[Value], options: Options) -> Value:
    return controller.signals.ask(values[0])


def _read_output(controller: "RapidController", values: Sequence[Value], options: Options) -> Value:
    return controller.signals.output(values[0])


def _take_degrees(compute: Callable[[float], float]) -> Callable[[float], float]:
    return lambda x: compute(math.radians(x))


def _give_degrees(compute: Callable[..., float]) -> Callable[..., float]:
    return lambda *x: math.degrees(compute(*x))


FUNCTIONS: Mapping[str, BuiltinFunction] = {
    **{
        name: _make_numeric(compute)
        for name, compute in dict[str, Callable[..., float]](
            {
                "Abs": abs,
                "Sqrt": math.sqrt,
                "Exp": math.exp,
                "Sin": _take_degrees(math.sin),
                "Cos": _take_degrees(math.cos),
                "Tan": _take_degrees(math.tan),
                "ASin": _give_degrees(math.asin),
                "ACos": _give_degrees(math.acos),
                "ATan": _give_degrees(math.atan),
                "NumToDnum": float,
                "DnumToNum": float,
            }
        ).items()
    },
    "Pow": _make_numeric(math.pow, 2),
    "ATan2": _make_numeric(_give_degrees(math.atan2), 2),
    "Max": _make_numeric(max, 2),
    "Min": _make_numeric(min, 2),
    "Trunc": _make_rounding(math.trunc),
    "Round": _make_rounding(_round_half_away),
    "Dim": BuiltinFunction(takes(ANY, NUM), NUM, _measure_dimension),
    "Distance": BuiltinFunction(
        takes(POS, POS), NUM, lambda _, values, __: float(np.linalg.norm(np.subtract(*values)))
    ),
    "VectMagn": BuiltinFunction(takes(POS), NUM, lambda _, values, __: float(np.linalg.norm(values[0]))),
    "DotProd": BuiltinFunction(takes(POS, POS), NUM, lambda _, values, __: float(np.dot(*values))),
    # texts
    "NumToStr": BuiltinFunction(takes(NUM, NUM, exp=None), STRING, _write_number),
    "ValToStr": BuiltinFunction(takes(ANY), STRING, lambda _, values, __: show_value(values[0])),
    "StrLen": BuiltinFunction(takes(STRING), NUM, lambda _, values, __: float(len(values[0]))),
    "StrPart": BuiltinFunction(takes(STRING, NUM, NUM), STRING, _cut_text),
    # the controller
    **{name: BuiltinFunction(takes(SIGNAL), NUM, _ask, fixed=False) for name in ("DInput", "GInput", "AInput")},
    **{
        name: BuiltinFunction(takes(SIGNAL), NUM, _read_output, fixed=False)
        for name in ("DOutput", "GOutput", "AOutput")
    },
    "TestDI": BuiltinFunction(takes(SIGNAL), BOOL, lambda *asked: _ask(*asked) != 0, fixed=False),
    "RobOS": BuiltinFunction(takes(), BOOL, lambda *_: True),
    "ClkRead": BuiltinFunction(takes(ANY), NUM, lambda *_: 0.0, fixed=False),
    "CDate": BuiltinFunction(takes(), STRING, lambda *_: "2000-01-01", fixed=False),
    "CTime": BuiltinFunction(takes(), STRING, lambda *_: "00:00:00", fixed=False),
}
"""Functions by name; RAPID reference manual (ABB 3HAC16581-1). Clocks stand still."""
