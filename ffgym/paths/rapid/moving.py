"""Instructions of RAPID that move the robot."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from ffgym.core.errors import errors_at
from ffgym.paths.moves import MoveArc, MoveJoint, MoveLinear, PathEvent
from ffgym.paths.rapid import records, targets
from ffgym.paths.rapid.arguments import Invocation
from ffgym.paths.rapid.controller import RapidController
from ffgym.paths.rapid.functions import ArgumentRule, CallRule, show_value
from ffgym.paths.rapid.predefined import TOOL0, WOBJ0
from ffgym.paths.rapid.records import Type, Value
from ffgym.paths.rapid.targets import Frame
from ffgym.paths.rapid.triggers import Trigger

_TARGET = ArgumentRule("target", records.ROBTARGET)
_VIA = ArgumentRule("point on the arc", records.ROBTARGET)
_SPEED = ArgumentRule("speed", records.SPEEDDATA)
_ZONE = ArgumentRule("zone", records.ZONEDATA)
_TOOL = ArgumentRule("tool", records.TOOLDATA)

OPTIONS: Mapping[str, Type | None] = {
    **{"v": records.NUM, "z": records.NUM, "wobj": records.WOBJDATA},
    # these change nothing here: concurrent logic, identity in MultiMove, in-position criterion, load, corrections
    **{"conc": None, "id": records.NUM, "inpos": records.STOPPOINTDATA, "tload": records.LOADDATA, "corr": None},
}
"""Options of every move."""


_Happens = Callable[[Invocation, Mapping[str, Value]], list[PathEvent]]
_Faster = Callable[[Mapping[str, Value], Mapping[str, Value]], Value | None]


@dataclass(frozen=True)
class MoveInstruction:
    """An instruction that moves the robot, and where its arguments are among those that it takes."""

    name: str
    shape: str
    """Path to the target: 'absolute', 'joint', 'line' or 'arc'."""
    between: tuple[ArgumentRule, ...] = ()
    """Arguments between speed and zone."""
    behind: tuple[ArgumentRule, ...] = ()
    """Arguments behind the tool."""
    options: Mapping[str, Type | None] | None = None
    """Options beside those of every move."""
    speed: _Faster | None = None
    """Speed of the TCP [mm/s] in place of that of the speeddata, from the arguments between speed and zone by name."""
    happens: _Happens | None = None
    """What happens on the way, from the arguments between and behind, by name."""

    @property
    def rule(self) -> CallRule:
        """Arguments that it takes."""
        target = ArgumentRule("target", records.JOINTTARGET) if self.shape == "absolute" else _TARGET
        goals = (_VIA, target) if self.shape == "arc" else (target,)
        own: Mapping[str, Type | None] = {"noeoffs": None} if self.shape == "absolute" else {}
        required = (*goals, _SPEED, *self.between, _ZONE, _TOOL, *self.behind)
        return CallRule(required, {**OPTIONS, **own, **(self.options or {})})

    def run(self, controller: RapidController, invocation: Invocation) -> None:
        """Add the move."""
        by_name = {
            parameter.name: value for parameter, value in zip(self.rule.parameters, invocation.values, strict=True)
        }
        place, options, tool = invocation.place, invocation.options, by_name["tool"]
        goals = [by_name[p.name] for p in (_VIA, _TARGET) if p.name in by_name]
        shape = self.shape
        if not controller.moves and shape == "arc":
            raise place.error(f"the first move is {self.name}, which needs a start; begin with MoveAbsJ or MoveJ.")
        if not controller.moves and shape == "line":
            controller.note(f"the first move is {self.name}; the motion starts at its target", place)
            shape = "joint"
        # joint moves may name tool0 beside another tool
        if shape in ("line", "arc") or tool != TOOL0:
            controller.use_tool(tool, invocation.places[len(goals) + 2 + len(self.between)])
        events = tuple(self.happens(invocation, by_name)) if self.happens else ()
        faster = self.speed(by_name, options) if self.speed else None
        with errors_at(str(place)):
            how: dict[str, Any] = {
                "speed": targets.speed(by_name["speed"], options.get("v", faster), controller.settings),
                "zone": targets.zone(by_name["zone"], options.get("z")),
                "label": invocation.labels[len(goals) - 1],
                "where": str(place),
                "events": events,
            }
            add_move(controller, shape, goals, invocation.labels, tool, options.get("wobj", WOBJ0), how)


def add_move(
    controller: RapidController,
    shape: str,
    goals: list[Value],
    names: Any,
    tool: Value,
    work_object: Value,
    how: dict[str, Any],
) -> None:
    """Add a move to targets, called `names`, of a tool in a work object; `how` are the other parts of the move."""
    at = controller.place
    if shape == "absolute":
        q = targets.joint_positions(goals[0], at.robot.kinematics.is_sliding, names[0])
        controller.add(MoveJoint(to=q, **how), tool)
        at.joints, at.flange = q, None
        return
    held = targets.tool_frame(tool)
    poses = [targets.pose(*target, held, work_object) for target in zip(goals, names, strict=False)]
    if shape == "arc":
        controller.add(MoveArc(via=poses[0].position, to=poses[1], **how), tool)
    elif shape == "line":
        controller.add(MoveLinear(to=poses[0], **how), tool)
    else:
        configuration = targets.quarter_turns(goals[0], names[0]) if controller.configured else None
        controller.add(MoveJoint(to=poses[0], **how), tool, configuration)
    rotation = poses[-1].rotation
    assert rotation is not None
    tcp = at.tool_frame(tool).position
    at.joints, at.flange = None, Frame(position=poses[-1].position - rotation @ tcp, rotation=rotation)
    at.tool, at.work_object, at.turns = tool, work_object, goals[-1][2]


_SIGNAL = ArgumentRule("signal", records.SIGNAL)
_NUMBER = ArgumentRule("value", records.NUM)


def _sets(word: str) -> _Happens:
    """Return what MoveLDO and its like do: they set an output at the target."""

    def happens(invocation: Invocation, by_name: Mapping[str, Value]) -> list[PathEvent]:
        text = f"{word} {by_name['signal']}, {show_value(by_name['value'])}"
        return [PathEvent(text=text, where=str(invocation.place))]

    return happens


def _triggers(invocation: Invocation, by_name: Mapping[str, Value]) -> list[PathEvent]:
    """Events of the triggers of TriggL and its like."""
    given = [by_name["trigger"], *(invocation.options.get(f"t{i}") for i in range(2, 9))]
    triggers: list[Trigger | None] = []
    for one in given:
        triggers += one if isinstance(one, tuple) else [one]
    if by_name["trigger"] is None:
        raise invocation.place.error(f"{invocation.labels[-3]} is not set; define it by TriggIO or TriggEquip before.")
    return [trigger.event(invocation.place) for trigger in triggers if trigger is not None]


def _weld_speed(by_name: Mapping[str, Value], options: Mapping[str, Value]) -> Value | None:
    """Speed of a weld [mm/s], the first component of its welddata."""
    return by_name["weld data"][0]


def _arc(text: str) -> _Happens:
    """Return what an instruction of Arc does at its target."""
    return lambda invocation, by_name: [PathEvent(text=f"{invocation.name}: {text}", where=str(invocation.place))]


_WELD = (ArgumentRule("seam data", records.SEAMDATA), ArgumentRule("weld data", records.WELDDATA))
_WELD_OPTIONS: Mapping[str, Type | None] = {"weave": records.WEAVEDATA, "seamname": records.STRING, "start": None}
_TRIGGER = (ArgumentRule("trigger", records.ANY),)
_TRIGGER_OPTIONS: Mapping[str, Type | None] = {f"t{i}": records.TRIGGDATA for i in range(2, 9)}
_LETTERS = {"J": "joint", "L": "line", "C": "arc"}


def _weld(name: str, letter: str, speed: _Faster | None, happens: _Happens | None) -> MoveInstruction:
    return MoveInstruction(name, _LETTERS[letter], _WELD, options=_WELD_OPTIONS, speed=speed, happens=happens)


def _move_instructions() -> list[MoveInstruction]:
    plain = [MoveInstruction("MoveAbsJ", "absolute")]
    for letter, shape in _LETTERS.items():
        plain += [
            MoveInstruction(f"Move{letter}", shape),
            MoveInstruction(f"Trigg{letter}", shape, _TRIGGER, options=_TRIGGER_OPTIONS, happens=_triggers),
            *(
                MoveInstruction(f"Move{letter}{kind}", shape, behind=(_SIGNAL, _NUMBER), happens=_sets(f"Set{kind}"))
                for kind in ("DO", "AO", "GO")
            ),
            MoveInstruction(
                f"Move{letter}Sync",
                shape,
                behind=(ArgumentRule("procedure", records.STRING),),
                happens=lambda invocation, by_name: [
                    PathEvent(text=f"calls {by_name['procedure']}", where=str(invocation.place))
                ],
            ),
        ]
    arcs = []
    for letter in "LC":
        arcs += [
            _weld(f"Arc{letter}Start", letter, None, _arc("arc on")),
            _weld(f"Arc{letter}", letter, _weld_speed, None),
            _weld(f"Arc{letter}End", letter, _weld_speed, _arc("arc off")),
        ]
    return plain + arcs


MOVES: Mapping[str, MoveInstruction] = {move.name: move for move in _move_instructions()}
"""Moves by name; RAPID reference manual (ABB 3HAC16581-1), and Arc (ABB 3HAC16588-1)."""
