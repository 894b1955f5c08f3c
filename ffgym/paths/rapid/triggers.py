"""Trigger data of RAPID: what is to happen at a place or a time near a target."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ffgym.paths.moves import PathEvent
from ffgym.paths.rapid.functions import ArgumentRule, CallRule, show_value
from ffgym.paths.rapid.records import ANY, NUM, SIGNAL, TRIGGDATA, Type, Value
from ffgym.paths.rapid.syntax import SourceLocation
from ffgym.paths.rapid.targets import MILLIMETRE

if TYPE_CHECKING:
    from ffgym.paths.rapid.arguments import Invocation
    from ffgym.paths.rapid.controller import RapidController


@dataclass(frozen=True)
class Trigger:
    """Event that is to happen on a move, and its place there."""

    text: str
    distance: float
    """Length before the target, or behind the start [m]."""
    from_start: bool
    lead: float
    """Time by which it happens earlier [s]."""

    def event(self, place: SourceLocation) -> PathEvent:
        """Event on the move that stands at a place in the program."""
        return PathEvent(
            text=self.text, where=str(place), distance=self.distance, from_start=self.from_start, lead=self.lead
        )


_OUTPUTS: Mapping[str, str] = {"dop": "SetDO", "gop": "SetGO", "aop": "SetAO"}
_OPTIONS: Mapping[str, Type | None] = {
    **{"start": None, "time": None, "next": None},
    **dict.fromkeys(_OUTPUTS, SIGNAL),
    **{"procid": NUM, "dodelay": NUM, "inhib": ANY, "inhibit": ANY, "mode": NUM},
}
_DATA = ArgumentRule("trigger data", TRIGGDATA, changes=True)


def _define(controller: "RapidController", invocation: "Invocation", lag: float, text: str) -> None:
    data, distance = invocation.values[:2]
    options = invocation.options
    if distance < 0:
        raise invocation.place.error(f"the distance of {invocation.name} is {distance:g}, must be >= 0.")
    timed = "time" in options
    data.set(
        Trigger(
            text=text,
            distance=0.0 if timed else distance * MILLIMETRE,
            from_start="start" in options,
            lead=(distance if timed else 0.0) + lag,
        )
    )


def _text_of(invocation: "Invocation", value: Value) -> str:
    """Tell what a trigger sets."""
    for option, word in _OUTPUTS.items():
        if option in invocation.options:
            return f"{word} {invocation.options[option]}, {show_value(value)}"
    return f"{invocation.name} {invocation.labels[0]}"


def _output(controller: "RapidController", invocation: "Invocation") -> None:
    r"""TriggIO: data, distance [mm] or with \Time [s], value."""
    delay = invocation.options.get("dodelay", 0.0)
    _define(controller, invocation, -delay, _text_of(invocation, invocation.values[2]))


def _equipment(controller: "RapidController", invocation: "Invocation") -> None:
    """TriggEquip: data, distance [mm], lag of the equipment [s], value."""
    _define(controller, invocation, invocation.values[2], _text_of(invocation, invocation.values[3]))


def _other(controller: "RapidController", invocation: "Invocation") -> None:
    """Triggers of interrupts, checks and speeds: data, distance [mm], and what is only told."""
    rest = ", ".join(show_value(value) for value in invocation.values[2:])
    _define(controller, invocation, 0.0, f"{invocation.name} {rest}".strip())


_DISTANCE, _VALUE = ArgumentRule("distance", NUM), ArgumentRule("value", ANY)

TRIGGERS = {
    "TriggIO": (CallRule((_DATA, _DISTANCE, _VALUE), _OPTIONS), _output),
    "TriggEquip": (CallRule((_DATA, _DISTANCE, ArgumentRule("lag", NUM), _VALUE), _OPTIONS), _equipment),
    "TriggInt": (CallRule((_DATA, _DISTANCE, _VALUE), _OPTIONS), _other),
    "TriggCheckIO": (
        CallRule(
            (_DATA, _DISTANCE, ArgumentRule("signal", SIGNAL), ArgumentRule("relation", ANY), _VALUE, _VALUE), _OPTIONS
        ),
        _other,
    ),
    "TriggSpeed": (
        CallRule((_DATA, _DISTANCE, ArgumentRule("lag", NUM), ArgumentRule("signal", SIGNAL), _VALUE), _OPTIONS),
        _other,
    ),
    "TriggRampAO": (
        CallRule(
            (_DATA, _DISTANCE, ArgumentRule("lag", NUM), ArgumentRule("signal", SIGNAL), _VALUE, _VALUE), _OPTIONS
        ),
        _other,
    ),
}
"""Instructions that define triggers; RAPID reference manual (ABB 3HAC16581-1)."""
