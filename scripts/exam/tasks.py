"""Tasks of an exam: the log that is diagnosed, and what only the examiner knows of it."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal, get_args

from ffgym.diagnosis.nuisance import ParameterPrior
from ffgym.recordings import Recording
from ffgym.robot import RobotDescription
from scripts.exam.equations import Clue

Row = Literal[
    "clean",
    "single",
    "foreign",
    "outside",
    "periodic",
    "pair",
    "poor",
    "poor_clean",
    "no_tracker",
    "no_temperature",
    "size",
    "arm",
    "arm_blind",
]
"""Kinds of questions: nothing hidden; an effect of the library; one in another equation; one outside the library; one
that repeats with the motor; two effects; small circles alone, with and without an effect; logs without a column; an
effect at several sizes on a robot of the user; friction behind the elasticity in another equation, with and without
a tracker."""

ROWS: tuple[Row, ...] = get_args(Row)

Question = tuple[Row, int]
"""Row and number within it, from 0 on."""


@dataclass(frozen=True, kw_only=True)
class Truth:
    """A hidden effect, as large as in the log."""

    effect: str
    """Name in the exam."""
    answer: str
    """Name that a diagnosis should give; empty outside the library."""
    joint: str
    """Empty for the machine as a whole."""
    is_foreign: bool
    """True if its equation is another than that of the library, so that sizes do not compare."""
    loudness: float
    """Distance from the noise, see `scripts.exam.loudness`."""
    numbers: dict[str, float]
    """Parameters by the names that causes have: `name.x` of vectors, `name.j4` of pairs."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Task:
    """Log of a question, with what a diagnosis is told of its machine."""

    row: Row
    number: int
    robot: RobotDescription
    """Description that the diagnosis is given."""
    log: Sequence[Recording]
    prior: ParameterPrior = field(default_factory=ParameterPrior)
    """Accuracy of the description that the diagnosis is given."""
    truth: tuple[Truth, ...] = ()
    clue: Clue | None = None
    """Clue that an answer must give to an effect outside the library."""
    conditions: str = ""
    """Description of a machine, controller and log that are drawn."""
