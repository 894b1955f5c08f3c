"""Both exams: what each asks, and what it demands."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal, final, get_args

from scripts.exam import draw
from scripts.exam.case import Row
from scripts.exam.figures import Line
from scripts.exam.independent import question
from scripts.exam.independent.table import independent_table
from scripts.exam.marks import Mark
from scripts.exam.table import table

ExamName = Literal["own", "independent"]
EXAM_NAMES: tuple[ExamName, ...] = get_args(ExamName)
"""Exams: logs of the project's own simulation of one robot; logs of a plant that shares nothing with it."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Exam:
    """What is asked and demanded."""

    counts: Mapping[Row, int]
    """Questions of a whole exam, by row."""
    table: Callable[[Sequence[Mark]], list[Line]]
    """Figures beside demands."""
    robot: str
    """Name of its robot."""
    prefix: str
    """Begins the names of files of marks."""

    def file_of(self, seed: int) -> str:
        """Name of the file of marks."""
        return f"{self.prefix}seed_{seed}.jsonl"


EXAMS: Mapping[ExamName, Exam] = MappingProxyType(
    {
        "own": Exam(counts=draw.COUNTS, table=table, robot=draw.ROBOT, prefix=""),
        "independent": Exam(counts=question.COUNTS, table=independent_table, robot="drawn", prefix="independent_"),
    }
)
"""Each exam by its name."""
