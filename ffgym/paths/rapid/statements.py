"""Statements of RAPID: linked once, run as often as the program comes to them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ffgym.core.errors import FFGymError
from ffgym.paths.rapid import syntax
from ffgym.paths.rapid.calls import Run, link_late_call, link_statement
from ffgym.paths.rapid.expressions import Typed, link_changeable, link_expression, link_operand
from ffgym.paths.rapid.loops import Loop, leaves
from ffgym.paths.rapid.records import BOOL, NUM
from ffgym.paths.rapid.routines import Returned
from ffgym.paths.rapid.scope import CallFrame, Datum

if TYPE_CHECKING:
    from ffgym.paths.rapid.linker import Scope


class Jump(Exception):
    """The program has come to GOTO."""

    def __init__(self, label: str) -> None:
        super().__init__()
        self.label = label


@dataclass(frozen=True)
class Block:
    """Statements one after the other."""

    steps: tuple[Run, ...]
    labels: dict[str, int]
    """Number of statements before each label, by name in lower case."""

    def run(self, frame: CallFrame) -> None:
        """Run all statements; a jump to a label goes on behind it."""
        i = 0
        while i < len(self.steps):
            try:
                self.steps[i](frame)
                i += 1
            except Jump as jump:
                if jump.label not in self.labels:
                    raise
                i = self.labels[jump.label]


@dataclass
class _Linker:
    """Links the statements of a routine."""

    scope: "Scope"
    routine: syntax.Routine
    labels: list[set[str]]
    """Labels that are in sight, of the blocks around a statement."""

    def block(self, statements: Sequence[syntax.Statement]) -> Block:
        """Link statements; errors go to the controller, one per statement at most."""
        steps: list[Run] = []
        labels: dict[str, int] = {}
        self.labels.append({s.name.lower() for s in statements if isinstance(s, syntax.Label)})
        for i, statement in enumerate(statements):
            try:
                if isinstance(statement, syntax.Label):
                    if statement.name.lower() in labels:
                        raise statement.place.error(f"label {statement.name} is declared twice.")
                    labels[statement.name.lower()] = len(steps)
                    continue
                steps.append(self._with_count(self._statement(statement, statements, i), statement.place))
            except FFGymError as error:
                self.scope.controller.errors.add(error)
        self.labels.pop()
        return Block(tuple(steps), labels)

    def _with_count(self, run: Run, place: syntax.SourceLocation) -> Run:
        controller = self.scope.controller

        def count_and_run(frame: CallFrame) -> None:
            controller.count(place)
            run(frame)

        return count_and_run

    def _statement(self, statement: syntax.Statement, block: Sequence[syntax.Statement], index: int) -> Run:
        if isinstance(statement, syntax.Call):
            return link_statement(self.scope, statement)
        if isinstance(statement, syntax.Assignment):
            return self._assignment(statement)
        if isinstance(statement, syntax.If):
            return self._if(statement)
        if isinstance(statement, syntax.For):
            return self._for(statement)
        if isinstance(statement, syntax.While):
            return self._while(statement)
        if isinstance(statement, syntax.Test):
            return self._test(statement)
        if isinstance(statement, syntax.Return):
            return self._return(statement)
        if isinstance(statement, syntax.Goto):
            return self._goto(statement, block[:index])
        assert isinstance(statement, syntax.LateCall)
        return link_late_call(self.scope, statement)

    def _assignment(self, statement: syntax.Assignment) -> Run:
        target = link_changeable(self.scope, statement.target)
        value = link_expression(self.scope, statement.value, target.type)
        return lambda frame: target.find(frame).set(value.value(frame))

    # course of the program

    def _if(self, statement: syntax.If) -> Run:
        branches = [(self._condition(condition), self.block(block)) for condition, block in statement.branches]
        otherwise = self.block(statement.otherwise)

        def run(frame: CallFrame) -> None:
            for condition, block in branches:
                if condition.value(frame):
                    block.run(frame)
                    return
            otherwise.run(frame)

        return run

    def _condition(self, expression: syntax.Expression) -> Typed:
        """Link a condition; an error in it does not hide those of its block."""
        try:
            return link_expression(self.scope, expression, BOOL)
        except FFGymError as error:
            self.scope.controller.errors.add(error)
            return Typed(BOOL, lambda frame: False, fixed=True)

    def _test(self, statement: syntax.Test) -> Run:
        value = link_operand(self.scope, statement.value)
        cases = [
            ([link_expression(self.scope, one, value.type) for one in values], self.block(block))
            for values, block in statement.cases
        ]
        otherwise = self.block(statement.otherwise)

        def run(frame: CallFrame) -> None:
            found = value.value(frame)
            for values, block in cases:
                if any(one.value(frame) == found for one in values):
                    block.run(frame)
                    return
            otherwise.run(frame)

        return run

    def _for(self, statement: syntax.For) -> Run:
        first, last = (link_expression(self.scope, bound, NUM) for bound in (statement.first, statement.last))
        step = None if statement.step is None else link_expression(self.scope, statement.step, NUM)
        local = self.scope.local
        hidden = local.meanings.get(statement.variable.lower())
        index = local.add(statement.variable, NUM, "FOR")
        block = self.block(statement.block)
        if hidden is None:
            del local.meanings[statement.variable.lower()]
        else:
            local.meanings[statement.variable.lower()] = hidden
        controller, place = self.scope.controller, statement.place

        def run(frame: CallFrame) -> None:
            number, end = first.value(frame), last.value(frame)
            # without STEP the counter goes down where it has to
            by = step.value(frame) if step is not None else 1.0 if number <= end else -1.0
            if by == 0:
                raise place.error("STEP is 0, so the loop would never end.")
            while number <= end if by > 0 else number >= end:
                controller.count(place)
                frame[index] = Datum(number)
                block.run(frame)
                number += by

        return run

    def _while(self, statement: syntax.While) -> Run:
        condition = self._condition(statement.condition)
        block = self.block(statement.block)
        program, place = self.scope.program, statement.place
        closed = condition.fixed and not leaves(statement.block)

        def run(frame: CallFrame) -> None:
            loop = Loop(program, place, closed=closed, asks=condition.asks)
            while condition.value(frame):
                program.controller.count(place)
                loop.begin(frame)
                block.run(frame)
                if not loop.goes_on(frame):
                    break

        return run

    def _goto(self, statement: syntax.Goto, before: Sequence[syntax.Statement]) -> Run:
        label, program, place = statement.label.lower(), self.scope.program, statement.place
        if not any(label in names for names in self.labels):
            raise place.error(f"label {statement.label} is not in sight; it must stand in a block around GOTO.")
        # back to a label of the same block, nothing between them that leaves: a loop without end
        names = [one.name.lower() if isinstance(one, syntax.Label) else "" for one in before]
        closed = label in names and not leaves(before[names.index(label) :], own=frozenset({label}))

        def run(frame: CallFrame) -> None:
            loop = frame.loops.get(place)
            if loop is None:
                loop = frame.loops[place] = Loop(program, place, closed=closed, asks=False)
            if loop.goes_on(frame):
                loop.begin(frame)
                raise Jump(label)

        return run

    def _return(self, statement: syntax.Return) -> Run:
        if self.routine.kind != "FUNC":
            if statement.value is not None:
                raise statement.place.error(f"{self.routine.kind} {self.routine.name} returns no value.")
            return lambda frame: _raise(Returned(None))
        if statement.value is None:
            raise statement.place.error(f"FUNC {self.routine.name} must return a value.")
        kind = self.scope.type_of(self.routine.type_name, self.routine.place)
        value = link_expression(self.scope, statement.value, kind)
        return lambda frame: _raise(Returned(value.value(frame)))


def _raise(error: Exception) -> None:
    raise error


def link_block(scope: "Scope", statements: Sequence[syntax.Statement], routine: syntax.Routine) -> Block:
    """Link the statements of a routine; errors go to the controller."""
    return _Linker(scope, routine, []).block(statements)
