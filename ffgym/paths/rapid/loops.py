"""Loops that never end: how often they are run, and what comes behind them."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from ffgym.paths.rapid import syntax
from ffgym.paths.rapid.instructions import ProgramEnd
from ffgym.paths.rapid.records import Value
from ffgym.paths.rapid.scope import CallFrame

if TYPE_CHECKING:
    from ffgym.paths.rapid.linker import LinkedProgram

_ENDS = frozenset(("exit", "exitcycle", "raise"))
"""Instructions that leave a loop, in lower case."""


def leaves(statements: Sequence[syntax.Statement], own: frozenset[str] = frozenset()) -> bool:
    """Tell if statements may leave the loop that they are in; jumps to labels among them or `own` stay inside."""
    labels = own | {statement.name.lower() for statement in statements if isinstance(statement, syntax.Label)}
    return any(_leaves(statement, labels) for statement in statements)


def _leaves(statement: syntax.Statement, labels: frozenset[str]) -> bool:
    if isinstance(statement, syntax.Return):
        return True
    if isinstance(statement, syntax.Goto):
        return statement.label.lower() not in labels
    if isinstance(statement, syntax.Call):
        return statement.name.lower() in _ENDS
    if isinstance(statement, syntax.If):
        return any(leaves(block, labels) for _, block in statement.branches) or leaves(statement.otherwise, labels)
    if isinstance(statement, syntax.Test):
        return any(leaves(block, labels) for _, block in statement.cases) or leaves(statement.otherwise, labels)
    return isinstance(statement, syntax.For | syntax.While) and leaves(statement.block, labels)


@dataclass
class Loop:
    """One run of a loop, which is cut short where it would never end.

    A closed loop, which has a constant condition and no statement that leaves it, is run for the cycles that are asked
    for. Another one is cut where a pass has changed nothing, as the next would do the same. The program ends there; a
    loop that only waits for an input, and moves nothing, is left instead.
    """

    program: "LinkedProgram"
    place: syntax.SourceLocation
    closed: bool
    asks: bool
    """True if the condition depends on inputs."""
    passes: int = 0
    _before: tuple[Value, ...] = field(default=())
    _moves: int = 0

    def begin(self, frame: CallFrame) -> None:
        """Begin a pass."""
        self._before = self._state(frame)
        self._moves = len(self.program.controller.moves)

    def goes_on(self, frame: CallFrame) -> bool:
        """Tell if there is another pass to be run after one has ended; False leaves the loop.

        Raises:
            ProgramEnd: if the loop would never end.
        """
        controller = self.program.controller
        self.passes += 1
        same = self._before == self._state(frame)
        if self.asks and (self.closed or same) and len(controller.moves) == self._moves:
            controller.note("a loop that waits for an input, left after one pass", self.place)
            return False
        if (self.closed and self.passes >= controller.cycles) or (same and self.passes >= controller.cycles):
            times = "once" if self.passes == 1 else f"{self.passes} times"
            controller.note(f"a loop without end, run {times} (cycles)", self.place)
            raise ProgramEnd
        return True

    def _state(self, frame: CallFrame) -> tuple[Value, ...]:
        local = tuple(None if reference is None else reference.get() for reference in frame)
        return (self.program.state(), local)
