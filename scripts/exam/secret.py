"""What marks need of a question, whichever exam it is of: what is hidden, how loud that is, and how it is named."""

from collections.abc import Sequence
from typing import Protocol

from ffgym.robot import RobotDescription
from scripts.exam.case import Row
from scripts.exam.equations import Clue


class Secret(Protocol):
    """An effect on one joint of a robot, or on all of it."""

    @property
    def name(self) -> str:
        """As the exam calls it."""

    @property
    def answer(self) -> str:
        """Name of the effect that a diagnosis should give; empty outside the library."""

    @property
    def joint(self) -> str:
        """Empty for the machine as a whole."""

    @property
    def is_foreign(self) -> bool:
        """Whether its equation is another than that of the library, so that sizes do not compare."""

    def clue(self, robot: RobotDescription) -> Clue | None:
        """What an answer must say of an effect outside the library."""

    def numbers(self, robot: RobotDescription) -> dict[str, float]:
        """Its parameters by the names that causes have: `name.x` of vectors, `name.j4` of pairs."""


class Asked(Protocol):
    """A question as it was handed out."""

    @property
    def row(self) -> Row:
        """Kind of question."""

    @property
    def number(self) -> int:
        """Within its row."""

    @property
    def robot(self) -> RobotDescription:
        """What is told of the machine."""

    @property
    def hidden(self) -> Sequence[Secret]:
        """As large as in the log."""

    @property
    def loudness(self) -> Sequence[float]:
        """Of each."""
