"""One question of an exam: a machine, what is hidden in it, and how it is recorded."""

from dataclasses import dataclass, replace
from typing import Literal, final, get_args

import numpy as np

from ffgym.core.types import Array
from ffgym.robot import RigidArm, RobotDescription
from ffgym.simulation.plant import Machine
from ffgym.simulation.protocols import Protocol
from ffgym.simulation.protocols.circles import Circles
from ffgym.simulation.protocols.diagnosis import Diagnosis
from scripts.exam.hidden import Hidden

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
]
"""Kinds of questions: nothing hidden; an effect of the library; one in another equation; one outside the library; one
that repeats with the motor; two effects; small circles alone, with and without an effect; logs without a column."""

ROWS: tuple[Row, ...] = get_args(Row)

PAUSE = 130.0
"""Time between motions of the protocol, in which the machine works and warms up [s]; chosen: 14 K in a session."""

POOR_SPEEDS = (0.010, 0.020, 0.040)
"""Speeds of the small circles that make a poor log [m/s]; those of the thesis' tables, and one between."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Case:
    """A machine whose model is wrong as models are, effects that may be hidden in it, and what is recorded of it."""

    row: Row
    number: int
    """Within its row, from 0 on."""
    arm: RigidArm
    """What is told of it: the nominal robot."""
    machine: Machine
    """Without what is hidden, but with the errors of calibration."""
    current_offset: Array
    """Of its current sensors, as torque, motor side [N m], shape (N,)."""
    hidden: tuple[Hidden, ...]
    """As large as they are plausible, until they are sized."""
    loudness: tuple[float, ...]
    """How far above the noise each is to be heard (`scripts.exam.loudness`); none leaves it as large as it is."""
    noise: tuple[int, ...]
    """Seed of the sensors' noise."""
    lacks: tuple[str, ...] = ()
    """Families of columns that the log does not have."""

    @property
    def name(self) -> str:
        """As in files of results."""
        return f"{self.row}-{self.number}"

    @property
    def complete(self) -> Machine:
        """The machine with all that is hidden in it."""
        return self.with_hidden(self.hidden)

    def with_hidden(self, hidden: tuple[Hidden, ...]) -> Machine:
        """The machine with these effects instead."""
        return replace(self.machine, effects=(*self.machine.effects, *(one.effect for one in hidden)))

    @property
    def is_poor(self) -> bool:
        """Whether its log is of small circles alone."""
        return self.row in ("poor", "poor_clean")

    def generator(self, *more: int) -> np.random.Generator:
        """Randomness of its own, another one for other numbers."""
        return np.random.default_rng((*self.noise, *more))


def protocol_of(robot: RobotDescription, *, poor: bool) -> Protocol:
    """What is recorded: the first protocol of any diagnosis, or a log that shows little."""
    area = robot.work_area
    if not poor or area is None:
        return Diagnosis(pause=PAUSE)
    return Circles(positions=(next(iter(area.positions)),), speeds=POOR_SPEEDS, pause=PAUSE)
