"""Running a program: names and types first, then statements one after the other, and the moves that they make."""

from collections.abc import Mapping, Sequence

from ffgym.core.errors import FFGymError, check_whole
from ffgym.paths.rapid import syntax
from ffgym.paths.rapid.controller import Execution, RapidController
from ffgym.paths.rapid.instructions import ProgramEnd
from ffgym.paths.rapid.linker import LinkedProgram
from ffgym.paths.rapid.place import RobotPlace
from ffgym.paths.rapid.routines import LinkedRoutine
from ffgym.paths.rapid.signals import read_inputs
from ffgym.robot import RobotDescription

MOST_CYCLES = 1000
"""Most passes through an endless loop; chosen: hours of a production program."""


def check_names(
    modules: Sequence[syntax.Module], entry: syntax.Routine | None, skipped: frozenset[str] = frozenset()
) -> list[FFGymError]:
    """Errors in names and types of the data of a program, and of what a procedure reaches.

    Names in `skipped`, in lower case, may be declared where a file could not be read.
    """
    controller = RapidController()
    try:
        _link(LinkedProgram(modules, controller, skipped), entry)
    except FFGymError as error:
        controller.errors.add(error)
    return controller.errors.errors


def _link(program: LinkedProgram, entry: syntax.Routine | None) -> LinkedRoutine | None:
    """Link data and all that a procedure reaches; errors go to the controller."""
    program.check_data()
    if entry is None:
        return None
    routine = program.find_linked(entry)
    if any(not parameter.optional for parameter in routine.parameters):
        raise entry.place.error(f"{entry.name} takes arguments; choose an entry without, that calls it.")
    program.reach(routine)
    program.link_reached()
    return routine


def execute(
    modules: Sequence[syntax.Module],
    entry: syntax.Routine,
    robot: RobotDescription,
    *,
    inputs: Mapping[str, float] | None = None,
    cycles: int = 1,
) -> Execution:
    """Run a procedure of a program for a robot.

    Args:
        modules: all modules of the program.
        entry: the procedure.
        robot: the robot.
        inputs: values of inputs by name; others are 0 until the program waits for them.
        cycles: passes through a loop that never ends.

    Raises:
        FFGymError: with all errors in names and types, or all that were met when it was run.
    """
    controller = RapidController(
        signals=read_inputs(inputs),
        cycles=check_whole("cycles", cycles, low=1, high=MOST_CYCLES),
        robot_place=RobotPlace(robot),
    )
    routine = _link(LinkedProgram(modules, controller), entry)
    assert routine is not None
    controller.errors.check()
    try:
        routine.run([None] * len(routine.parameters), entry.place)
    except ProgramEnd:
        pass
    except FFGymError as error:
        controller.errors.add(error)
    controller.errors.check()
    if not controller.moves:
        waits = f" Inputs that were {controller.signals.notes()[0]}." if controller.signals.assumed else ""
        raise entry.place.error(f"the program makes no move.{waits}")
    return controller.finish()
