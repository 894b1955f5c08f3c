"""Instructions of RAPID that do not move the robot: settings of the motion, signals, waits, and what is only told."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from ffgym.paths.rapid import records
from ffgym.paths.rapid.arguments import Invocation
from ffgym.paths.rapid.controller import RapidController
from ffgym.paths.rapid.functions import ArgumentRule, CallRule, takes
from ffgym.paths.rapid.moving import MOVES
from ffgym.paths.rapid.records import BOOL, NUM, SIGNAL, STRING, Type
from ffgym.paths.rapid.targets import MILLIMETRE
from ffgym.paths.rapid.triggers import TRIGGERS


@dataclass(frozen=True)
class Instruction:
    """An instruction: what it takes, and what it does."""

    name: str
    rule: CallRule | None
    """Arguments that it takes; None for any."""
    run: Callable[[RapidController, Invocation], None]


def _percent(invocation: Invocation, index: int, low: float, high: float) -> float:
    """Share of an argument in percent, cut to the range that the controller cuts it to."""
    return min(max(invocation.values[index], low), high) / 100


def _acc_set(controller: RapidController, invocation: Invocation) -> None:
    """AccSet: acceleration and ramp in percent; the controller takes 20 and 10 at least."""
    controller.settings = replace(
        controller.settings,
        acceleration=_percent(invocation, 0, 20, 100),
        ramp=_percent(invocation, 1, 10, 100),
    )


def _vel_set(controller: RapidController, invocation: Invocation) -> None:
    """VelSet: override in percent, largest speed of the TCP [mm/s]."""
    override, fastest = invocation.values
    if not (0 < override <= 100 and fastest > 0):
        raise invocation.place.error(f"VelSet {override:g}, {fastest:g} must be in (0, 100] % and > 0 mm/s.")
    controller.settings = replace(controller.settings, override=override / 100, fastest=fastest * MILLIMETRE)


def _conf_j(controller: RapidController, invocation: Invocation) -> None:
    r"""ConfJ \On or \Off: whether MoveJ follows robconf."""
    controller.configured = _one_switch(invocation) == "on"


def _one_switch(invocation: Invocation) -> str:
    if len(invocation.options) != 1:
        raise invocation.place.error(f"{invocation.name} wants one switch, {invocation.name} \\On or \\Off.")
    (switch,) = invocation.options
    return switch


def _no_effect(controller: RapidController, invocation: Invocation) -> None:
    """Do what holds anyway, or what concerns the controller alone."""


def _tell(controller: RapidController, invocation: Invocation) -> None:
    """Tell what happens, and where."""
    controller.happen(invocation.text, invocation.place)


def _set(value: float | None) -> Callable[[RapidController, Invocation], None]:
    """Return a function that sets an output to a value, or to the second argument."""

    def run(controller: RapidController, invocation: Invocation) -> None:
        controller.signals.set(invocation.values[0], invocation.values[1] if value is None else value)
        _tell(controller, invocation)

    return run


def _invert(controller: RapidController, invocation: Invocation) -> None:
    (signal,) = invocation.values
    controller.signals.set(signal, 1.0 - controller.signals.output(signal))
    _tell(controller, invocation)


def _wait_signal(controller: RapidController, invocation: Invocation) -> None:
    """Pass a wait for a signal, which has its value then."""
    signal, value = invocation.values
    controller.signals.set(signal, value)
    if "timeflag" in invocation.options:
        invocation.options["timeflag"].set(False)
    _tell(controller, invocation)


def _wait_time(controller: RapidController, invocation: Invocation) -> None:
    r"""WaitTime, maybe with \InPos, which a robot that stands still fulfils; no time is no rest."""
    (duration,) = invocation.values
    if duration < 0:
        raise invocation.place.error(f"WaitTime {duration:g} s must be >= 0.")
    if duration > 0:
        controller.rest(duration, invocation.place)


def _change(change: Callable[..., float]) -> Callable[[RapidController, Invocation], None]:
    """Return a function that changes a number."""

    def run(controller: RapidController, invocation: Invocation) -> None:
        data, *rest = invocation.values
        data.set(float(change(data.get(), *rest)))

    return run


class ProgramEnd(Exception):
    """The program has come to its end."""


def _end(controller: RapidController, invocation: Invocation) -> None:
    _tell(controller, invocation)
    raise ProgramEnd


def _goes_wrong(controller: RapidController, invocation: Invocation) -> None:
    raise invocation.place.error(
        f"the program comes to {invocation.name}, an error of its own, which is not run on; change what leads to it, "
        "e.g. the inputs."
    )


def _load(controller: RapidController, invocation: Invocation) -> None:
    controller.note("GripLoad changes no mass here; the robot holds the load of its tool all along", invocation.place)
    _tell(controller, invocation)


_SIGNAL_AND_VALUE = (ArgumentRule("signal", SIGNAL), ArgumentRule("value", NUM))
_NUMBER = ArgumentRule("variable", NUM, changes=True)
_ON_OFF: Mapping[str, Type | None] = {"on": None, "off": None}
WAIT_OPTIONS: Mapping[str, Type | None] = {
    **{"maxtime": NUM, "timeflag": BOOL, "visualize": None, "inpos": None, "zerospeed": None, "polldelay": NUM},
    **{"valueattimeout": NUM, "header": STRING, "message": STRING},
}

_KNOWN: Mapping[str, tuple[CallRule, Callable[[RapidController, Invocation], None]]] = {
    # settings of the motion
    "AccSet": (
        CallRule((ArgumentRule("acceleration", NUM), ArgumentRule("ramp", NUM)), {"finepointramp": NUM}),
        _acc_set,
    ),
    "VelSet": (CallRule((ArgumentRule("override", NUM), ArgumentRule("largest speed", NUM))), _vel_set),
    "ConfJ": (CallRule((), _ON_OFF), _conf_j),
    "ConfL": (CallRule((), _ON_OFF), _no_effect),
    "SingArea": (CallRule((), {"wrist": None, "off": None, "lockaxis4": None}), _no_effect),
    # signals and waits
    **{
        f"Set{kind}": (
            CallRule(_SIGNAL_AND_VALUE, {"sdelay": NUM, "sync": None}),
            _set(None),
        )
        for kind in ("DO", "GO", "AO")
    },
    "Set": (CallRule(_SIGNAL_AND_VALUE[:1]), _set(1.0)),
    "Reset": (CallRule(_SIGNAL_AND_VALUE[:1]), _set(0.0)),
    "PulseDO": (CallRule(_SIGNAL_AND_VALUE[:1], {"plength": NUM, "high": None}), _tell),
    "InvertDO": (CallRule(_SIGNAL_AND_VALUE[:1]), _invert),
    **{
        f"Wait{kind}": (CallRule(_SIGNAL_AND_VALUE, WAIT_OPTIONS, changed=frozenset({"timeflag"})), _wait_signal)
        for kind in ("DI", "DO", "GI", "GO", "AI", "AO")
    },
    "WaitTime": (CallRule((ArgumentRule("time", NUM),), {"inpos": None}), _wait_time),
    "WaitRob": (CallRule((), {"inpos": None, "zerospeed": None}), _tell),
    # numbers
    "Incr": (CallRule((_NUMBER,)), _change(lambda x: x + 1)),
    "Decr": (CallRule((_NUMBER,)), _change(lambda x: x - 1)),
    "Add": (CallRule((_NUMBER, ArgumentRule("number", NUM))), _change(lambda x, y: x + y)),
    "Clear": (CallRule((_NUMBER,)), _change(lambda x: 0.0)),
    # course of the program
    "EXIT": (takes(), _end),
    "ExitCycle": (takes(), _end),
    **{name: (takes(), _goes_wrong) for name in ("RAISE", "RETRY", "TRYNEXT")},
    "GripLoad": (CallRule((ArgumentRule("load", records.LOADDATA),)), _load),
    **TRIGGERS,
}

TOLD = (
    *(
        "TPWrite",
        "TPReadFK",
        "TPReadNum",
        "Stop",
        "Break",
        "MotionSup",
        "PathResol",
        "PathAccLim",
        "WorldAccLim",
        "CirPathMode",
        "SoftAct",
    ),
    *("SoftDeact", "StopMove", "StartMove", "StorePath", "RestoPath", "StopMoveReset", "ActUnit", "DeactUnit", "Load"),
    *("UnLoad", "Open", "Close", "Write", "UIMsgBox", "UIShow", "ErrWrite", "ErrLog", "WaitLoad", "TuneServo"),
    *("TuneReset", "MechUnitLoad", "CONNECT", "ISignalDI", "ISignalDO", "ISignalGI", "ISignalAI", "ITimer", "IWatch"),
)
"""Instructions of which only the place on the path is told; their arguments may be anything."""

IGNORED = (
    *("TPErase", "TPShow", "ClkReset", "ClkStart", "ClkStop", "IDelete", "IEnable", "IDisable", "ISleep", "BookErrNo"),
    *("CornerPathWarning", "TextTabInstall", "SpyStart", "SpyStop", "SetSysData", "AliasIO"),
    *("ActEventBuffer", "DeactEventBuffer", "EOffsOff", "SystemStopAction", "WarmStart", "ResetRetryCount"),
)
"""Instructions of which nothing is told; their arguments may be anything, and data that they would change keep their
values."""

INSTRUCTIONS: Mapping[str, Instruction] = {
    instruction.name.lower(): instruction
    for instruction in (
        *(Instruction(name, move.rule, move.run) for name, move in MOVES.items()),
        *(Instruction(name, rule, run) for name, (rule, run) in _KNOWN.items()),
        *(Instruction(name, None, _tell) for name in TOLD),
        *(Instruction(name, None, _no_effect) for name in IGNORED),
    )
}
"""Instructions by name in lower case; RAPID reference manual (ABB 3HAC16581-1). WaitUntil, which takes a condition
apart, is a statement."""
