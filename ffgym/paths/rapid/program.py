"""A RAPID program: read once, run for a robot."""

from dataclasses import dataclass
from pathlib import Path

from ffgym.core.errors import FFGymError
from ffgym.paths.rapid.evaluate import check_unique, declared_type
from ffgym.paths.rapid.interpreter import INSTRUCTIONS, Execution, execute
from ffgym.paths.rapid.syntax import Module, Procedure, Source, read_source, unified
from ffgym.robot import RobotDescription

MAIN = "main"
"""Procedure that is run if none is named; RAPID's own choice."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Program:
    """A program that was read: grammar, names and types of its data are right."""

    source: Source
    module: Module

    def execute(self, robot: RobotDescription, entry: str | None = None) -> Execution:
        """Moves of a procedure for a robot, and the robot with the program's tool.

        Args:
            robot: the robot; its number and kind of joints count, and its flange.
            entry: name of the procedure; None takes main, or the only one.

        Raises:
            FFGymError: if there is no such procedure, or it cannot be run; the message begins with the place.
        """
        return execute(self.source, self.module, self._entry(entry), robot)

    def _entry(self, name: str | None) -> Procedure:
        procedures = {procedure.name.lower(): procedure for procedure in self.module.procedures}
        if not procedures:
            raise FFGymError(f"{self.source.name}: has no procedure; a program needs PROC main() ... ENDPROC.")
        if name is None and len(procedures) == 1:
            return self.module.procedures[0]
        wanted = MAIN if name is None else name
        if wanted.lower() not in procedures:
            names = ", ".join(procedure.name for procedure in self.module.procedures)
            raise FFGymError(f"{self.source.name}: has no procedure {wanted}; choose one as entry: {names}.")
        return procedures[wanted.lower()]


def parse_program(text: str, where: str = "program") -> Program:
    """Read a program from text; `where` names it in messages.

    Raises:
        FFGymError: if it is no program of the supported subset; the message begins with 'where:line:column'.
    """
    return _checked(Source(name=where, text=unified(text)))


def load_program(path: str | Path) -> Program:
    """Read a program from a file, UTF-8 or Latin-1.

    Raises:
        FFGymError: if the file cannot be read, or holds no program of the supported subset.
    """
    return _checked(read_source(path))


def _checked(source: Source) -> Program:
    try:
        from ffgym.paths.rapid.reader import read  # needs lark, which the core does not
    except ImportError as error:
        raise FFGymError("RAPID programs need lark; pip install 'ffgym[paths]'.") from error
    module = read(source)
    check_unique(source, (*module.declarations, *module.procedures))
    for declaration in module.declarations:
        declared_type(source, declaration)
    for procedure in module.procedures:
        if procedure.name.lower() in (name.lower() for name in INSTRUCTIONS):
            raise source.error(procedure.place, f"{procedure.name} is an instruction of RAPID; choose another name.")
    return Program(source=source, module=module)
