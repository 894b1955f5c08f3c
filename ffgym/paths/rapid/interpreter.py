"""Running a program: statements one after the other, and the moves that they make."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from ffgym.core.errors import errors_at
from ffgym.paths.moves import Move, MoveArc, MoveJoint, MoveLinear, Wait
from ffgym.paths.rapid import records, syntax, targets
from ffgym.paths.rapid.evaluate import ArgumentRule, Scope, arguments_of, check_unique, declare, evaluate
from ffgym.robot import RobotDescription

_HOW = (
    ArgumentRule("speed", records.SPEEDDATA, {"v": records.NUM}),
    ArgumentRule("zone", records.ZONEDATA, {"z": records.NUM}),
    ArgumentRule("tool", records.TOOLDATA, {"wobj": records.WOBJDATA}),
)
"""Arguments of every move behind its targets."""

_TARGET = ArgumentRule("target", records.ROBTARGET)

MOVES: Mapping[str, tuple[ArgumentRule, ...]] = {
    "moveabsj": (ArgumentRule("target", records.JOINTTARGET, {"noeoffs": None}), *_HOW),
    "movej": (_TARGET, *_HOW),
    "movel": (_TARGET, *_HOW),
    "movec": (ArgumentRule("point on the arc", records.ROBTARGET), _TARGET, *_HOW),
}
"""Moves by name in lower case."""

SWITCHES: Mapping[str, tuple[str, ...]] = {
    "confj": ("on", "off"),
    "confl": ("on", "off"),
    "singarea": ("off",),
}
"""Instructions that take one switch, and the switches that are supported."""

INSTRUCTIONS = ("MoveAbsJ", "MoveC", "MoveJ", "MoveL", "WaitTime", "ConfJ", "ConfL", "SingArea", "AccSet")
"""All of them, as they are written."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Execution:
    """Moves of a program, for one robot with one tool."""

    robot: RobotDescription
    """Holds the program's tool."""
    moves: tuple[Move, ...]
    configurations: tuple[targets.Configuration | None, ...]
    """One per move: the branch that the target asks for; None where the nearest is taken."""


def _name(scope: Scope, target: syntax.Expression | None) -> str:
    r"""Label a target for messages and phases: its name, and the displacement of a displaced one.

    These are its arguments and their options, e.g. 'Offs(p10, 0, -20\Rx:=5)', whatever was written for the numbers.
    """
    if isinstance(target, syntax.VariableReference):
        return target.name
    if not isinstance(target, syntax.Call):
        return "target"
    displaced, *by = target.arguments
    words = [_name(scope, displaced.value)]
    for argument in by:
        parts = [("", argument.value), *((f"\\{option.name}:=", option.value) for option in argument.options)]
        numbers = [f"{name}{evaluate(scope, value, records.NUM) + 0.0:g}" for name, value in parts if value is not None]
        words.append("".join(numbers))
    return f"{target.name}({', '.join(words)})"


MAX_CALLS = 50
"""Deepest nesting of procedure calls; chosen: cutting programs need three, and Python's stack must not end."""

MAX_STATEMENTS = 100_000
"""Most statements that are run; chosen: hours of motion, and procedures that double each other must come to an end."""

_ACC_SET = (ArgumentRule("acceleration", records.NUM), ArgumentRule("ramp", records.NUM))
_WAIT_TIME = (ArgumentRule("time", records.NUM),)


def execute(module: syntax.Module, entry: syntax.Procedure, robot: RobotDescription) -> Execution:
    """Run a procedure of a module for a robot."""
    scope = Scope()
    for declaration in module.declarations:
        scope.module[declaration.name.lower()] = declare(scope, declaration)
    procedures = {procedure.name.lower(): procedure for procedure in module.procedures}
    interpreter = Interpreter(robot, scope, procedures)
    interpreter.run(entry)
    if not interpreter.moves:
        raise entry.place.error("the program makes no move.")
    tool, first = interpreter.tool or (records.TOOL0, entry.place)
    with errors_at(str(first)):
        held = targets.with_tool(robot, tool, f"tooldata in {first}")
    return Execution(robot=held, moves=tuple(interpreter.moves), configurations=tuple(interpreter.configurations))


@dataclass
class Interpreter:
    """One run of a program, and the moves that it has made until then."""

    robot: RobotDescription
    scope: Scope
    procedures: Mapping[str, syntax.Procedure]
    """Data by name in lower case."""
    moves: list[Move] = field(default_factory=list)
    configurations: list[targets.Configuration | None] = field(default_factory=list)
    tool: tuple[records.Value, syntax.SourceLocation] | None = None
    """The tool that all moves share, and where it was first seen."""
    configured: bool = True
    """True if MoveJ follows robconf, which ConfJ switches."""
    _calls: list[syntax.Procedure] = field(default_factory=list)
    """Procedures that have begun and not ended."""
    _statements: int = 0

    def run(self, procedure: syntax.Procedure) -> None:
        """Run a procedure with data of its own."""
        outer, self.scope.local = self.scope.local, {}
        self._calls.append(procedure)
        check_unique(procedure.declarations)
        for declaration in procedure.declarations:
            if declaration.kind == "PERS":
                raise declaration.place.error(
                    f"{declaration.name} is PERS in a procedure; declare it in the module, or as VAR."
                )
            self.scope.local[declaration.name.lower()] = declare(self.scope, declaration)
        for statement in procedure.statements:
            self._run(statement)
        self._calls.pop()
        self.scope.local = outer

    def _run(self, statement: syntax.Statement) -> None:
        self._statements += 1
        place = statement.place
        if self._statements > MAX_STATEMENTS:
            raise place.error(f"the program runs more than {MAX_STATEMENTS} statements.")
        if isinstance(statement, syntax.Assignment):
            wanted = self.scope.type_of(statement.target)
            self.scope.set(statement.target, evaluate(self.scope, statement.value, wanted))
            return
        name = statement.name.lower()
        if name in MOVES:
            self._move(statement)
        elif name in SWITCHES:
            self._switch(statement)
        elif name == "waittime":
            self._wait(statement)
        elif name == "accset":
            if arguments_of(self.scope, statement, _ACC_SET)[0] != [100.0, 100.0]:
                raise place.error(
                    "AccSet is supported as AccSet 100, 100 only; acceleration is limited for the whole motion."
                )
        else:
            self._call(statement)

    def _move(self, instruction: syntax.Call) -> None:
        """Add the move of an instruction of MOVES."""
        kind, place = instruction.name.lower(), instruction.place
        if not self.moves and kind in ("movel", "movec"):
            raise place.error(
                f"the first move is {instruction.name}, which needs a start; begin with MoveAbsJ or MoveJ."
            )
        (*goals, speed_data, zone_data, tool), options = arguments_of(self.scope, instruction, MOVES[kind])
        names = [_name(self.scope, argument.value) for argument in instruction.arguments[: len(goals)]]
        absolute = kind == "moveabsj"
        # MoveAbsJ may name tool0 beside another tool, as its target depends on none
        if not absolute or tool != records.TOOL0:
            named = instruction.arguments[-1].value
            if self.tool is None:
                self.tool = (tool, place if named is None else named.place)
            elif self.tool[0] != tool:
                here = place if named is None else named.place
                raise here.error(f"this tool is not the one of {self.tool[1]}; a program moves with one tool.")
        with errors_at(str(place)):
            how: dict[str, Any] = {
                "speed": targets.speed(speed_data, options.get("v")),
                "zone": targets.zone(zone_data, options.get("z")),
                "label": names[-1],
                "where": str(place),
            }
            if absolute:
                sliding = self.robot.kinematics.is_sliding
                self._add(MoveJoint(to=targets.joint_positions(goals[0], sliding, names[0]), **how))
                return
            held, work_object = targets.tool_frame(tool), options.get("wobj", records.WOBJ0)
            poses = [targets.pose(*target, held, work_object) for target in zip(goals, names, strict=True)]
            if kind == "movec":
                self._add(MoveArc(via=poses[0].position, to=poses[1], **how))
            elif kind == "movel":
                self._add(MoveLinear(to=poses[0], **how))
            else:
                configuration = targets.quarter_turns(goals[0], names[0]) if self.configured else None
                self._add(MoveJoint(to=poses[0], **how), configuration)

    def _add(self, move: Move, configuration: targets.Configuration | None = None) -> None:
        self.moves.append(move)
        self.configurations.append(configuration)

    def _switch(self, instruction: syntax.Call) -> None:
        """ConfJ decides whether MoveJ follows robconf; the others say what holds anyway."""
        name, allowed = instruction.name, SWITCHES[instruction.name.lower()]
        options = [option for argument in instruction.arguments for option in argument.options]
        values = [argument.value for argument in instruction.arguments if argument.value is not None]
        switch = options[0].name.lower() if options else ""
        if values or len(options) != 1 or options[0].value is not None or switch not in allowed:
            choices = " or ".join(f"{name} \\{option.capitalize()}" for option in allowed)
            raise instruction.place.error(f"{name} is supported as {choices} only.")
        if name.lower() == "confj":
            self.configured = switch == "on"

    def _wait(self, instruction: syntax.Call) -> None:
        r"""WaitTime, maybe with \InPos, which a robot that stands still fulfils; no time is no rest."""
        arguments, place = instruction.arguments, instruction.place
        if len(arguments) == 2 and arguments[0].value is None and arguments[0].names() == ["inpos"]:
            instruction = instruction._replace(arguments=arguments[1:])
        (duration,), _ = arguments_of(self.scope, instruction, _WAIT_TIME)
        if not self.moves or not self.moves[-1].zone.stops:
            raise place.error(
                "WaitTime needs a robot that stands still; end the move before it with fine, not with a zone."
            )
        if duration < 0:
            raise place.error(f"WaitTime {duration:g} s must be >= 0.")
        if duration > 0:
            self._add(Wait(duration=duration, label=f"wait {duration:g} s", where=str(place)))

    def _call(self, instruction: syntax.Call) -> None:
        place = instruction.place
        procedure = self.procedures.get(instruction.name.lower())
        if procedure is None:
            raise place.error(
                f"{instruction.name} is not supported, and no procedure of this program. Available: "
                f"{', '.join(INSTRUCTIONS)}. Comment it out with '!', or write out what it does."
            )
        if instruction.arguments:
            raise place.error(f"{procedure.name} takes no arguments.")
        if procedure in self._calls:
            raise place.error(f"{procedure.name} calls itself, which would never end.")
        if len(self._calls) >= MAX_CALLS:
            raise place.error(f"procedures call each other more than {MAX_CALLS} deep.")
        self.run(procedure)
