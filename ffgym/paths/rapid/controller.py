"""One run of a program: what it has moved, set and waited for until then."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from ffgym.core.errors import errors_at
from ffgym.paths.moves import Move, MoveArc, MoveJoint, MoveLinear, PathEvent, Pose, Wait
from ffgym.paths.rapid import targets
from ffgym.paths.rapid.place import RobotPlace
from ffgym.paths.rapid.predefined import TOOL0
from ffgym.paths.rapid.records import Value
from ffgym.paths.rapid.scope import ErrorList
from ffgym.paths.rapid.signals import ControllerSignals
from ffgym.paths.rapid.syntax import SourceLocation
from ffgym.paths.rapid.targets import MotionSettings
from ffgym.robot import RobotDescription

MAX_STATEMENTS = 50_000
"""Most statements that are run again; chosen: hours of motion, and a program that never ends is told within 10 s."""

MAX_ERRORS = 1000
"""Errors after which a program is run no further; chosen: more than anybody reads."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Execution:
    """Moves of a program, for one robot with one tool."""

    robot: RobotDescription
    """Holds the program's tool."""
    moves: tuple[Move, ...]
    configurations: tuple[targets.Configuration | None, ...]
    """One per move: the branch that the target asks for; None where the nearest is taken."""
    notes: tuple[str, ...] = ()
    """What was assumed, left out or cut short; a line each."""


@dataclass
class PlannedMove:
    """A move that was made, before the tool of the whole program is known."""

    move: Move
    configuration: targets.Configuration | None
    tool: Value
    """Tool whose TCP its pose is of."""


@dataclass
class RapidController:
    """State of a robot and its controller while a program runs."""

    signals: ControllerSignals = field(default_factory=ControllerSignals)
    cycles: int = 1
    """Passes through a loop that never ends."""
    robot_place: RobotPlace | None = None
    """Place of the robot; None while names are only checked, and nothing is run."""
    errors: ErrorList = field(default_factory=ErrorList)
    settings: MotionSettings = field(default_factory=MotionSettings)
    configured: bool = True
    """True if MoveJ follows robconf, which ConfJ switches."""
    moves: list[PlannedMove] = field(default_factory=list)
    events: list[tuple[int, PathEvent]] = field(default_factory=list)
    """Events with the number of moves made before them."""
    notes: list[str] = field(default_factory=list)
    tool: tuple[Value, SourceLocation] | None = None
    """The tool that all moves share, and where it was first seen."""
    reached: set[SourceLocation] = field(default_factory=set)
    """Statements that were run."""
    repeats: int = 0
    """Statements that were run again."""

    @property
    def place(self) -> RobotPlace:
        """Place of the robot."""
        assert self.robot_place is not None
        return self.robot_place

    def count(self, place: SourceLocation) -> None:
        """Count a statement; a program that runs the same ones too often will not end, however long it is."""
        if len(self.errors.errors) >= MAX_ERRORS:
            raise place.error(f"the program is run no further after {MAX_ERRORS} errors.")
        if place not in self.reached:
            self.reached.add(place)
            return
        self.repeats += 1
        if self.repeats > MAX_STATEMENTS:
            raise place.error(
                f"the program repeats more than {MAX_STATEMENTS} statements, and makes {len(self.moves)} moves. Give "
                "inputs that end its loops, cycles for the passes of endless ones, or another entry."
            )

    def note(self, text: str, place: SourceLocation) -> None:
        """Note something about the program, once."""
        line = f"{place}: {text}"
        if line not in self.notes:
            self.notes.append(line)

    def happen(self, text: str, place: SourceLocation) -> None:
        """Add an event at the target of the last move."""
        self.events.append((len(self.moves), PathEvent(text=text, where=str(place))))

    def add(self, move: Move, tool: Value, configuration: targets.Configuration | None = None) -> None:
        """Add a move."""
        self.moves.append(PlannedMove(move, configuration, tool))

    def use_tool(self, tool: Value, place: SourceLocation) -> None:
        """Refuse a second tool."""
        if self.tool is None:
            self.tool = (tool, place)
        elif self.tool[0] != tool:
            raise place.error(f"this tool is not the one of {self.tool[1]}; a program moves with one tool.")

    def rest(self, duration: float, place: SourceLocation) -> None:
        """Stand still for a time [s] > 0; a move before it that does not stop does so then."""
        if not self.moves:
            self.happen(f"WaitTime {duration:g}", place)
            return
        last = self.moves[-1]
        if not last.move.zone.stops:
            last.move = replace(last.move, zone=type(last.move.zone)())
            self.note(f"the robot stops at {last.move.label!r} for WaitTime, in spite of its zone", place)
        with errors_at(str(place)):
            self.add(Wait(duration=duration, label=f"wait {duration:g} s", where=str(place)), last.tool)

    def finish(self) -> Execution:
        """Moves with their events, for the robot with the tool of the program."""
        tool, first = self.tool or (TOOL0, None)
        with errors_at(str(first or "")):
            held = targets.with_tool(self.place.robot, tool, f"tooldata in {first}")
        return Execution(
            robot=held,
            moves=tuple(self._with_events([self._of_tool(planned, tool) for planned in self.moves])),
            configurations=tuple(planned.configuration for planned in self.moves),
            notes=(*self.notes, *self.signals.notes()),
        )

    def _of_tool(self, planned: PlannedMove, tool: Value) -> Move:
        """Move whose pose is that of the program's tool, for one with tool0 beside another tool."""
        move = planned.move
        if planned.tool == tool or not isinstance(move, MoveLinear | MoveArc | MoveJoint):
            return move
        pose = move.to
        if not isinstance(pose, Pose) or pose.rotation is None:
            return move
        shift = self.place.tool_frame(tool).position - self.place.tool_frame(planned.tool).position
        return replace(move, to=replace(pose, position=pose.position + pose.rotation @ shift))

    def _with_events(self, moves: Sequence[Move]) -> list[Move]:
        """Moves with what happens on the way; what comes before the first move happens at its start."""
        before = [replace(event, from_start=True) for count, event in self.events if count == 0]
        events: list[list[PathEvent]] = [list(move.events) for move in moves]
        events[0] = [*before, *events[0]]
        for count, event in self.events:
            if count > 0:
                events[count - 1].append(event)
        return [replace(move, events=tuple(own)) for move, own in zip(moves, events, strict=True)]
