"""Runs the procedures of a program, which gives its moves."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from ffgym.paths.rapid.arguments import Parameter, pair
from ffgym.paths.rapid.evaluate import declare, evaluate, evaluate_arguments
from ffgym.paths.rapid.execution import Execution
from ffgym.paths.rapid.instructions import INSTRUCTIONS, MOVES, SWITCHES
from ffgym.paths.rapid.move_builder import MoveBuilder
from ffgym.paths.rapid.records import NUM
from ffgym.paths.rapid.scope import Scope, check_unique
from ffgym.paths.rapid.source import Source
from ffgym.paths.rapid.syntax import Argument, Assignment, Declaration, Instruction, Module, Procedure, Statement
from ffgym.robot import RobotDescription

MAX_CALLS = 50
"""Deepest nesting of procedure calls; chosen: cutting programs need three, and Python's stack must not end."""

MAX_STATEMENTS = 100_000
"""Most statements that are run; chosen: hours of motion, and procedures that double each other must come to an end."""

_ACC_SET = (Parameter("acceleration", NUM), Parameter("ramp", NUM))
_WAIT_TIME = (Parameter("time", NUM),)


def execute(source: Source, module: Module, entry: Procedure, robot: RobotDescription) -> Execution:
    """Run a procedure of a module for a robot.

    Raises:
        FFGymError: if a statement cannot be run; the message begins with its place.
    """
    scope = Scope(source)
    for declaration in module.declarations:
        scope.module[declaration.name.lower()] = declare(scope, declaration)
    builder = MoveBuilder(source, robot)
    procedures = {procedure.name.lower(): procedure for procedure in module.procedures}
    Interpreter(scope, procedures, builder).run(entry)
    return builder.finish(entry.place)


@dataclass
class Interpreter:
    """One run of a program."""

    scope: Scope
    procedures: Mapping[str, Procedure]
    """By name in lower case."""
    builder: MoveBuilder
    _calls: list[Procedure] = field(default_factory=list)
    """Procedures that have begun and not ended."""
    _statements: int = 0

    def run(self, procedure: Procedure) -> None:
        """Run a procedure with data of its own.

        Raises:
            FFGymError: if one of its statements cannot be run.
        """
        outer, self.scope.local = self.scope.local, {}
        self._calls.append(procedure)
        check_unique(self.scope.source, procedure.declarations)
        for declaration in procedure.declarations:
            self._declare(declaration)
        for statement in procedure.statements:
            self._run(statement)
        self._calls.pop()
        self.scope.local = outer

    def _declare(self, declaration: Declaration) -> None:
        if declaration.kind == "PERS":
            raise self.scope.source.error(
                declaration.place, f"{declaration.name} is PERS in a procedure; declare it in the module, or as VAR."
            )
        self.scope.local[declaration.name.lower()] = declare(self.scope, declaration)

    def _run(self, statement: Statement) -> None:
        self._statements += 1
        place = statement.place
        if self._statements > MAX_STATEMENTS:
            raise self.scope.source.error(place, f"the program runs more than {MAX_STATEMENTS} statements.")
        if isinstance(statement, Assignment):
            wanted = self.scope.type_of(statement.target)
            self.scope.set(statement.target, evaluate(self.scope, statement.value, wanted))
            return
        name = statement.name.lower()
        if name in MOVES:
            self.builder.move(self.scope, statement)
        elif name in SWITCHES:
            self._switch(statement)
        elif name == "waittime":
            self._wait(statement)
        elif name == "accset":
            self._acc_set(statement)
        else:
            self._call(statement)

    def _switch(self, instruction: Instruction) -> None:
        """ConfJ decides whether MoveJ follows robconf; the others say what holds anyway."""
        name, allowed = instruction.name, SWITCHES[instruction.name.lower()]
        options = [option for argument in instruction.arguments for option in argument.options]
        values = [argument.value for argument in instruction.arguments if argument.value is not None]
        switch = options[0].name.lower() if options else ""
        if values or len(options) != 1 or options[0].value is not None or switch not in allowed:
            choices = " or ".join(f"{name} \\{option.capitalize()}" for option in allowed)
            raise self.scope.source.error(instruction.place, f"{name} is supported as {choices} only.")
        if name.lower() == "confj":
            self.builder.configured = switch == "on"

    def _wait(self, instruction: Instruction) -> None:
        r"""WaitTime, maybe with \InPos, which a robot that stands still fulfils."""
        arguments = instruction.arguments
        if len(arguments) == 2 and arguments[0].value is None and arguments[0].names() == ["inpos"]:
            arguments = arguments[1:]
        (time,) = self._numbers(instruction, arguments, _WAIT_TIME)
        self.builder.wait(instruction.place, time)

    def _acc_set(self, instruction: Instruction) -> None:
        """AccSet with the values that hold anyway."""
        values = self._numbers(instruction, instruction.arguments, _ACC_SET)
        if values != [100.0, 100.0]:
            raise self.scope.source.error(
                instruction.place,
                "AccSet is supported as AccSet 100, 100 only; acceleration is limited for the whole motion.",
            )

    def _numbers(
        self, instruction: Instruction, arguments: Sequence[Argument], parameters: tuple[Parameter, ...]
    ) -> list[float]:
        paired = pair(self.scope.source, instruction.name, instruction.place, arguments, parameters)
        return evaluate_arguments(self.scope, paired, parameters)[0]

    def _call(self, instruction: Instruction) -> None:
        source, place = self.scope.source, instruction.place
        procedure = self.procedures.get(instruction.name.lower())
        if procedure is None:
            raise source.error(
                place,
                f"{instruction.name} is not supported, and no procedure of this program. Available: "
                f"{', '.join(INSTRUCTIONS)}. Comment it out with '!', or write out what it does.",
            )
        if instruction.arguments:
            raise source.error(place, f"{procedure.name} takes no arguments.")
        if procedure in self._calls:
            raise source.error(place, f"{procedure.name} calls itself, which would never end.")
        if len(self._calls) >= MAX_CALLS:
            raise source.error(place, f"procedures call each other more than {MAX_CALLS} deep.")
        self.run(procedure)
