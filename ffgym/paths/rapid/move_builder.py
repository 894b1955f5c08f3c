"""Moves of a program as they come, from its move instructions."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

from ffgym.core.errors import FFGymError
from ffgym.paths.moves import Move, MoveArc, MoveJoint, MoveLinear, Pose, Wait
from ffgym.paths.rapid.arguments import pair
from ffgym.paths.rapid.evaluate import evaluate, evaluate_arguments
from ffgym.paths.rapid.execution import Configuration, Execution
from ffgym.paths.rapid.instructions import MOVES
from ffgym.paths.rapid.predefined import TOOL0, WOBJ0
from ffgym.paths.rapid.records import NUM, Value
from ffgym.paths.rapid.scope import Scope
from ffgym.paths.rapid.source import Source
from ffgym.paths.rapid.syntax import Argument, Call, Expression, Instruction, Place, Reference
from ffgym.paths.rapid.targets import joint_positions, pose, quarter_turns, speed, zone
from ffgym.paths.rapid.tools import tool_frame, with_tool
from ffgym.robot import RobotDescription


@dataclass
class MoveBuilder:
    """Collects the moves of one run of a program."""

    source: Source
    robot: RobotDescription
    moves: list[Move] = field(default_factory=list)
    configurations: list[Configuration | None] = field(default_factory=list)
    configured: bool = True
    """Whether MoveJ follows robconf, which ConfJ switches."""
    _tool: tuple[Value, Place] | None = None
    """The tool that all moves share, and where it was first seen."""

    def move(self, scope: Scope, instruction: Instruction) -> None:
        """Add the move of an instruction of MOVES.

        Raises:
            FFGymError: if an argument is wrong, or the move cannot stand here.
        """
        kind, place = instruction.name.lower(), instruction.place
        if not self.moves and kind in ("movel", "movec"):
            raise self.source.error(
                place, f"the first move is {instruction.name}, which needs a start; begin with MoveAbsJ or MoveJ."
            )
        paired = pair(self.source, instruction.name, place, instruction.arguments, MOVES[kind])
        values, options = evaluate_arguments(scope, paired, MOVES[kind])
        *targets, speed_data, zone_data, tool = values
        names = [_name(scope, target) for target in paired.values[: len(targets)]]
        self._use(tool, paired.values[-1].place, absolute=kind == "moveabsj")
        with self._at(place):
            how: dict[str, Any] = {
                "speed": speed(speed_data, options.get("v")),
                "zone": zone(zone_data, options.get("z")),
                "label": names[-1],
                "where": self.source.at(place),
            }
            if kind == "moveabsj":
                self._add(MoveJoint(to=joint_positions(targets[0], self.robot.kinematics.is_sliding, names[0]), **how))
            else:
                held, work_object = tool_frame(tool), options.get("wobj", WOBJ0)
                poses = [pose(*target, held, work_object) for target in zip(targets, names, strict=True)]
                follows = kind == "movej" and self.configured
                self._add(_to_pose(kind, poses, how), quarter_turns(targets[0], names[0]) if follows else None)

    def wait(self, place: Place, duration: float) -> None:
        """Add a rest [s], which nothing is if it takes no time.

        Raises:
            FFGymError: if the robot does not stand still here.
        """
        if not self.moves or not self.moves[-1].zone.stops:
            raise self.source.error(
                place, "WaitTime needs a robot that stands still; end the move before it with fine, not with a zone."
            )
        if duration < 0:
            raise self.source.error(place, f"WaitTime {duration:g} s must be >= 0.")
        if duration > 0:
            self._add(Wait(duration=duration, label=f"wait {duration:g} s", where=self.source.at(place)))

    def finish(self, place: Place) -> Execution:
        """Everything that was collected; `place` is that of the entry.

        Raises:
            FFGymError: if there is no move, or the robot cannot hold the tool.
        """
        if not self.moves:
            raise self.source.error(place, "the program makes no move.")
        tool, first = self._tool or (TOOL0, place)
        with self._at(first):
            robot = with_tool(self.robot, tool, f"tooldata in {self.source.at(first)}")
        return Execution(robot=robot, moves=tuple(self.moves), configurations=tuple(self.configurations))

    def _add(self, move: Move, configuration: Configuration | None = None) -> None:
        self.moves.append(move)
        self.configurations.append(configuration)

    def _use(self, tool: Value, place: Place, *, absolute: bool) -> None:
        """Remember the tool; MoveAbsJ may name tool0 beside another, as its target depends on no tool."""
        if absolute and tool == TOOL0:
            return
        if self._tool is None:
            self._tool = (tool, place)
        elif self._tool[0] != tool:
            raise self.source.error(
                place, f"this tool is not the one of {self.source.at(self._tool[1])}; a program moves with one tool."
            )

    @contextmanager
    def _at(self, place: Place) -> Iterator[None]:
        """Let errors begin with a place."""
        try:
            yield
        except FFGymError as error:
            raise self.source.error(place, str(error)) from error


def _to_pose(kind: str, poses: Sequence[Pose], how: Mapping[str, Any]) -> Move:
    """Move to the last of some poses, on an arc through the one before."""
    if kind == "movec":
        return MoveArc(via=poses[0].position, to=poses[1], **how)
    if kind == "movel":
        return MoveLinear(to=poses[0], **how)
    return MoveJoint(to=poses[0], **how)


def _name(scope: Scope, target: Expression | None) -> str:
    """What messages and phases call a target: its name, of a displaced one with the numbers that it is displaced by."""
    if isinstance(target, Reference):
        return target.name
    if not isinstance(target, Call):
        return "target"
    displaced, *by = target.arguments
    return f"{target.name}({', '.join([_name(scope, displaced.value), *(_written(scope, part) for part in by)])})"


def _written(scope: Scope, argument: Argument) -> str:
    r"""An argument that is a number, and its options, e.g. '-20\Rx:=5', whatever was written for the numbers."""
    named = [("", argument.value), *((f"\\{option.name}:=", option.value) for option in argument.options)]
    return "".join(f"{name}{evaluate(scope, value, NUM) + 0.0:g}" for name, value in named if value is not None)
