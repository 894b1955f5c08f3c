"""Statements of RAPID that call: procedures of the program and instructions."""

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeAlias

from ffgym.core.errors import FFGymError
from ffgym.paths.rapid import syntax
from ffgym.paths.rapid.arguments import Invocation, Linked, check_readable, link_anything, link_arguments
from ffgym.paths.rapid.expressions import Typed, link_expression
from ffgym.paths.rapid.functions import CallRule
from ffgym.paths.rapid.instructions import INSTRUCTIONS, WAIT_OPTIONS, Instruction
from ffgym.paths.rapid.moving import MOVES
from ffgym.paths.rapid.records import BOOL, NUM, SIGNAL, STRING
from ffgym.paths.rapid.routines import link_call
from ffgym.paths.rapid.scope import CallFrame

if TYPE_CHECKING:
    from ffgym.paths.rapid.linker import Scope

Run: TypeAlias = Callable[[CallFrame], None]
"""What a statement does, with the data of the call of its routine."""

_SHOWN = frozenset({"TPWrite"})
"""Instructions with arguments of any kind whose values are told instead of what was written."""


def _ignore(value: object) -> None:
    """A procedure has no value."""


def link_statement(scope: "Scope", call: syntax.Call) -> Run:
    """Link a call of a procedure of the program, or an instruction.

    Raises:
        FFGymError: if there is none of that name, or it takes other arguments; it begins with the place.
    """
    check_readable(call)
    name = call.name.lower()
    routine = scope.find_routine(call.name)
    if routine is not None:
        if routine.routine.kind == "FUNC":
            raise call.place.error(f"{call.name} is a FUNC; assign its value.")
        bind, _ = link_call(scope, call, routine)
        scope.program.reach(routine)
        return lambda frame: _ignore(routine.run(bind(frame), call.place))
    if name == "waituntil":
        return _wait_until(scope, call)
    instruction = INSTRUCTIONS.get(name)
    if instruction is None:
        if name in scope.program.skipped:
            return lambda frame: None
        raise call.place.error(
            f"{call.name} is not supported, and no procedure of this program. Comment it out with '!', or write "
            "out what it does; docs/rapid.md lists all instructions."
        )
    rule = instruction.rule
    linked = link_anything(scope, call) if rule is None else link_arguments(scope, call, rule)
    return _instruction(scope, call, instruction, linked)


def _instruction(scope: "Scope", call: syntax.Call, instruction: Instruction, linked: Linked) -> Run:
    controller = scope.controller
    shown = call.text if instruction.rule is None and instruction.name not in _SHOWN else ""
    goes_on = instruction.name in MOVES
    places = [value.place for value in call.values]
    names = {option.name.lower(): option.name for option in call.options}

    def run(frame: CallFrame) -> None:
        try:
            labels = [label(frame) for label in linked.labels]
            values, options = linked.values(frame), linked.options(frame)
            made = Invocation(call.name, call.place, values, options, labels, places, names, shown)
            instruction.run(controller, made)
        except FFGymError as error:
            if not goes_on:
                raise
            controller.errors.add(error)  # one move that cannot be made does not hide the next

    return run


def _wait_until(scope: "Scope", call: syntax.Call) -> Run:
    """Link a wait for a condition, which holds then as far as it is about signals."""
    rule = CallRule((), WAIT_OPTIONS, changed=frozenset({"timeflag"}))
    if len(call.values) != 1:
        raise call.place.error(f"the arguments of {call.name} are (condition), got {len(call.values)} of 1.")
    condition = link_expression(scope, call.values[0], BOOL)
    options = link_arguments(scope, call._replace(values=()), rule)
    facts = list(_facts(scope, call.values[0]))
    controller = scope.controller

    def run(frame: CallFrame) -> None:
        for signal, value in facts:
            controller.signals.set(signal.value(frame), value.value(frame))
        given = options.options(frame)
        if "timeflag" in given:
            given["timeflag"].set(False)
        controller.happen(call.text, call.place)
        if not condition.value(frame):
            controller.note("the condition is taken as fulfilled", call.place)

    return run


def _facts(scope: "Scope", condition: syntax.Expression) -> "list[tuple[Typed, Typed]]":
    """ControllerSignals and values that a condition says are equal."""
    if not isinstance(condition, syntax.OperatorChain):
        return []
    operands = [condition.first, *(operand for _, operand in condition.rest)]
    if condition.rest[0][0] == "AND":
        return [fact for operand in operands for fact in _facts(scope, operand)]
    if condition.rest[0][0] != "=":
        return []
    left, right = operands
    if isinstance(left, syntax.Call) and left.name.lower() in ("dinput", "ginput", "ainput", "doutput"):
        (left,) = left.values
    if not isinstance(left, syntax.VariableReference):
        return []
    meaning = scope.find(left.name)
    if meaning is not None and meaning.type != SIGNAL:
        return []
    return [(link_expression(scope, left, SIGNAL), link_expression(scope, right, NUM))]


def link_late_call(scope: "Scope", statement: syntax.LateCall) -> Run:
    """Link a call of a procedure whose name is found when the program runs, which is linked then."""
    name = link_expression(scope, statement.name, STRING)
    call = statement.call

    def run(frame: CallFrame) -> None:
        found = scope.find_routine(name.value(frame))
        if found is None or found.routine.kind != "PROC":
            raise call.place.error(f"there is no procedure {name.value(frame)!r}, which is called here.")
        bind, _ = link_call(scope, call._replace(name=found.routine.name), found)
        scope.program.reach(found)
        scope.program.link_reached()
        scope.controller.errors.check()
        found.run(bind(frame), call.place)

    return run
