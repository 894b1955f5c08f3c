"""A RAPID program: read once, run for a robot, with joint moves on the branches that its targets ask for."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ffgym.core.errors import FFGymError, errors_at
from ffgym.core.types import Array
from ffgym.paths.moves import Move, MoveJoint, Pose, locate_error
from ffgym.paths.rapid.evaluate import check_unique, find_type
from ffgym.paths.rapid.interpreter import INSTRUCTIONS, Execution, execute
from ffgym.paths.rapid.syntax import Module, decode, unify_line_ends
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
    moves, notes = list(execution.moves), []
    if arm.robot.n_joints != 6 or np.any(arm.robot.kinematics.is_sliding):
        return execution.moves, ()
    q = arm.robot.kinematics.range.mean(axis=1) if arm.robot.work_area is None else arm.robot.work_area.home
    for i, (move, wanted) in enumerate(zip(execution.moves, execution.configurations, strict=True)):
        if isinstance(move, MoveJoint) and not isinstance(move.to, Pose):
            q = move.to
        elif isinstance(move, MoveJoint) and isinstance(move.to, Pose) and wanted is not None:
            pose = move.to
            with errors_at(move.where):
                found = [solve_pose(arm, pose.position, pose.rotation, q)]
                if not _has(found[0], wanted):
                    every = pose_solutions(arm, pose.position, pose.rotation, q)
                    found = [other for other in every if _has(other, wanted)]
            if found:
                q = found[0]
                moves[i] = replace(move, to=q)
            else:
                turns = "robconf cf1, cf4, cf6 = " + ", ".join(map(str, wanted))
                notes.append(str(locate_error(move, f"no solution for {move.label} has {turns}; the nearest is taken")))
    return tuple(moves), tuple(notes)


def _has(q: Array, wanted: Configuration) -> bool:
    """Tell if joint positions (N,) have the quarter turns of robconf, up to the rounding of targets."""
    low = np.array(wanted) * np.pi / 2
    return bool(np.all((q[_AXES] > low - _EDGE) & (q[_AXES] < low + np.pi / 2 + _EDGE)))


MAIN = "main"
"""Procedure that is run if none is named; RAPID's own choice."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Program:
    """A program that was read: grammar, names and types of its data are right."""

    name: str
    """Name of its file, for messages."""
    module: Module

    def execute(self, robot: RobotDescription, entry: str | None = None) -> Execution:
        """Moves of a procedure for a robot, and the robot with the program's tool.

        Args:
            robot: the robot; its number and kind of joints count, and its flange.
            entry: name of the procedure; None takes main, or the only one.

        Raises:
            FFGymError: if there is no such procedure, or it cannot be run; the message begins with the place.
        """
        procedures = {procedure.name.lower(): procedure for procedure in self.module.procedures}
        if not procedures:
            raise FFGymError(f"{self.name}: has no procedure; a program needs PROC main() ... ENDPROC.")
        wanted = MAIN if entry is None else entry
        if entry is None and len(procedures) == 1:
            (wanted,) = procedures
        if wanted.lower() not in procedures:
            names = ", ".join(procedure.name for procedure in self.module.procedures)
            raise FFGymError(f"{self.name}: has no procedure {wanted}; choose one as entry: {names}.")
        return execute(self.module, procedures[wanted.lower()], robot)


def parse_program(text: str, where: str = "program") -> Program:
    """Read a program from text; `where` names it in messages.

    Raises:
        FFGymError: if it is no program of the supported subset; the message begins with 'where:line:column'.
    """
    return _checked(where, unify_line_ends(text))


def load_program(path: str | Path) -> Program:
    """Read a program from a file, UTF-8 or Latin-1.

    Raises:
        FFGymError: if the file cannot be read, or holds no program of the supported subset.
    """
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise FFGymError(f"Cannot read RAPID program {path}: {error.strerror}.") from error
    return _checked(Path(path).name, decode(data))


def _checked(name: str, text: str) -> Program:
    try:
        from ffgym.paths.rapid.reader import read  # needs lark, which the core does not
    except ImportError as error:
        raise FFGymError("RAPID programs need lark; pip install 'ffgym[paths]'.") from error
    module = read(name, text)
    check_unique((*module.declarations, *module.procedures))
    for declaration in module.declarations:
        find_type(declaration)
    for procedure in module.procedures:
        if procedure.name.lower() in (name.lower() for name in INSTRUCTIONS):
            raise procedure.place.error(f"{procedure.name} is an instruction of RAPID; choose another name.")
    return Program(name=name, module=module)
