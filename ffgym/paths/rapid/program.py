"""A RAPID program: read once, run for a robot, with joint moves on the branches that its targets ask for."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from ffgym.core.errors import FFGymError, errors_at
from ffgym.core.files import read_bytes
from ffgym.core.types import Array
from ffgym.paths.moves import Move, MoveJoint, Pose, locate_error
from ffgym.paths.rapid.controller import Execution
from ffgym.paths.rapid.instructions import INSTRUCTIONS
from ffgym.paths.rapid.interpreter import check_names, execute
from ffgym.paths.rapid.scope import ErrorList, join_errors
from ffgym.paths.rapid.syntax import Module, Routine, decode, unify_line_ends
from ffgym.paths.rapid.targets import Configuration
from ffgym.robot import RigidArm, RobotDescription, pose_solutions, solve_pose

_AXES = [0, 3, 5]
"""Joints whose quarter turns cf1, cf4 and cf6 count."""

_EDGE = 1e-3
"""Tolerance of a quarter turn [rad]; chosen: targets are rounded, and axes often stand at 0 deg."""


def on_branches(arm: RigidArm, execution: Execution) -> tuple[tuple[Move, ...], tuple[str, ...]]:
    """Moves whose joint moves end on the branches that their targets ask for, and notes where they cannot.

    robconf describes arms of six hinges; other arms take the nearest branch. Where no solution has the quarter turns
    that are asked for, the move keeps its pose, so that the nearest branch is taken, and a note says so.

    Args:
        arm: the execution's robot.
        execution: moves and configurations.

    Raises:
        FFGymError: if a target is out of reach; the message begins with the move's place.
    """
    moves, notes, errors = list(execution.moves), [], ErrorList()
    if arm.robot.n_joints != 6 or np.any(arm.robot.kinematics.is_sliding):
        return execution.moves, ()
    q = _home(arm)
    for i, (move, wanted) in enumerate(zip(execution.moves, execution.configurations, strict=True)):
        if isinstance(move, MoveJoint) and not isinstance(move.to, Pose):
            q = move.to
        elif isinstance(move, MoveJoint) and isinstance(move.to, Pose) and wanted is not None:
            pose = move.to
            try:
                with errors_at(move.where):
                    found = [solve_pose(arm, pose.position, pose.rotation, q)]
            except FFGymError as error:
                errors.add(error)
                continue
            if not _has(found[0], wanted):
                every = pose_solutions(arm, pose.position, pose.rotation, q)
                found = [other for other in every if _has(other, wanted)]
            if found:
                q = found[0]
                moves[i] = replace(move, to=q)
            else:
                turns = "robconf cf1, cf4, cf6 = " + ", ".join(map(str, wanted))
                notes.append(str(locate_error(move, f"no solution for {move.label} has {turns}; the nearest is taken")))
    if errors.errors:
        raise join_errors([*errors.errors, *find_unreachable(arm, moves, *errors.errors)])
    return tuple(moves), tuple(notes)


def _home(arm: RigidArm) -> Array:
    area = arm.robot.work_area
    return arm.robot.kinematics.range.mean(axis=1) if area is None else area.home


def find_unreachable(arm: RigidArm, moves: Sequence[Move], *known: FFGymError) -> list[FFGymError]:
    """Errors at all targets that the robot cannot reach, but those at places that known errors tell of already."""
    q, errors = _home(arm), ErrorList()
    for move in moves:
        target = getattr(move, "to", None)
        if any(str(error).startswith(f"{move.where}:") for error in known) or not isinstance(target, Pose):
            continue
        try:
            with errors_at(move.where):
                q = solve_pose(arm, target.position, target.rotation, q)
        except FFGymError as error:
            errors.add(error)
    return errors.errors


def _has(q: Array, wanted: Configuration) -> bool:
    """Tell if joint positions (N,) have the quarter turns of robconf, up to the rounding of targets."""
    low = np.array(wanted) * np.pi / 2
    return bool(np.all((q[_AXES] > low - _EDGE) & (q[_AXES] < low + np.pi / 2 + _EDGE)))


MAIN = "main"
"""Procedure that is run if none is named; RAPID's own choice."""


@dataclass(frozen=True, kw_only=True)
class Program:
    """A program that was read: its grammar is right."""

    name: str
    """Name of its file, for messages."""
    modules: tuple[Module, ...]

    @property
    def procedures(self) -> dict[str, Routine]:
        """Procedures by name in lower case; of local ones with the same name the first."""
        found: dict[str, Routine] = {}
        for module in self.modules:
            for routine in module.routines:
                if routine.kind == "PROC":
                    found.setdefault(routine.name.lower(), routine)
        return found

    def execute(
        self,
        robot: RobotDescription,
        entry: str | None = None,
        *,
        inputs: Mapping[str, float] | None = None,
        cycles: int = 1,
    ) -> Execution:
        """Moves of a procedure for a robot, and the robot with the program's tool.

        Args:
            robot: the robot; its number and kind of joints count, and its flange.
            entry: name of the procedure; None takes main, or the only one.
            inputs: values of inputs by name; others are 0 until the program waits for them.
            cycles: passes through a loop that never ends.

        Raises:
            FFGymError: if there is no such procedure, or it cannot be run; each line begins with the place of an error.
        """
        procedures = self.procedures
        if not procedures:
            raise FFGymError(f"{self.name}: has no procedure; a program needs PROC main() ... ENDPROC.")
        wanted = MAIN if entry is None else entry
        if entry is None and len(procedures) == 1:
            (wanted,) = procedures
        if wanted.lower() not in procedures:
            names = ", ".join(procedure.name for procedure in procedures.values())
            raise FFGymError(f"{self.name}: has no procedure {wanted}; choose one as entry: {names}.")
        return execute(self.modules, procedures[wanted.lower()], robot, inputs=inputs, cycles=cycles)


def parse_program(text: str, where: str = "program") -> Program:
    """Read a program from text; `where` names it in messages.

    Raises:
        FFGymError: if it is none; each line of the message begins with the 'where:line:column' of an error.
    """
    return _read(where, [(where, unify_line_ends(text))])


def load_program(path: str | Path) -> Program:
    """Read a program from a file, UTF-8 or Latin-1.

    A .pgf file names the modules of a program; system modules (.sys) beside it belong to it.

    Raises:
        FFGymError: if a file cannot be read, or holds no program; each line of the message begins with a place.
    """
    path = Path(path)
    files = [path] if path.suffix.lower() != PROGRAM_SUFFIX else _files_of(path)
    return _read(path.name, [(file.name, decode(_bytes_of(file))) for file in files])


PROGRAM_SUFFIX = ".pgf"
"""Suffix of files that name the modules of a program."""


def _bytes_of(path: Path) -> bytes:
    try:
        return read_bytes(path)
    except FFGymError as error:
        raise FFGymError(f"Cannot read RAPID program {error}") from error


def _files_of(path: Path) -> list[Path]:
    """Files of the modules that a .pgf file names, and of the system modules beside it."""
    try:
        names = [element.text or "" for element in ElementTree.fromstring(_bytes_of(path)).iter("Module")]
    except ElementTree.ParseError as error:
        raise FFGymError(f"{path.name}: is no list of modules in XML ({error}); see docs/rapid.md.") from error
    if not names:
        raise FFGymError(f"{path.name}: names no modules; it needs <Module>NAME.mod</Module>.")
    system = sorted(file for file in path.parent.iterdir() if file.suffix.lower() == ".sys")
    return [*(path.parent / name.strip() for name in names), *system]


def _read(name: str, texts: Sequence[tuple[str, str]]) -> Program:
    """Read the texts of a program, each with the name of its file."""
    try:
        from ffgym.paths.rapid.reader import read  # needs lark, which the core does not
    except ImportError as error:
        raise FFGymError("RAPID programs need lark; pip install 'ffgym[paths]'.") from error
    files = [read(file, text) for file, text in texts]
    program = Program(name=name, modules=tuple(module for file in files for module in file.modules))
    for procedure in program.procedures.values():
        instruction = INSTRUCTIONS.get(procedure.name.lower())
        if instruction is not None and instruction.rule is not None:
            raise procedure.place.error(f"{procedure.name} is an instruction of RAPID; choose another name.")
    errors = [error for file in files for error in file.errors]
    if errors:
        # what else is wrong in what could be read, so that all can be mended at once
        if all(file.modules for file in files):
            skipped = frozenset(word for file in files for word in file.skipped)
            errors += check_names(program.modules, program.procedures.get(MAIN), skipped)
        raise join_errors(errors)
    return program
