"""Sizes and frequencies in an answer, beside the true ones."""

from dataclasses import dataclass
from typing import final

import numpy as np

from ffgym.diagnosis.result import Cause, Diagnosis
from ffgym.effects import EFFECTS
from ffgym.robot import RobotDescription
from scripts.exam.secret import Secret

_SHAPE = 0.1
"""Relative error of a shape that is chosen beside the size beyond which sizes mean different things."""


@final
@dataclass(frozen=True, kw_only=True)
class SizeMark:
    """A size in an answer, and the true one, in the unit of the parameter."""

    name: str
    said: float
    true: float
    interval: tuple[float, float]
    scale: float
    """How far the true one is from null; of a vector its length."""

    @property
    def error(self) -> float:
        """Relative."""
        return abs(self.said - self.true) / self.scale

    @property
    def is_covered(self) -> bool:
        """Whether the interval holds the true size."""
        return self.interval[0] <= self.true <= self.interval[1]


def _causes(hidden: Secret, answer: Diagnosis) -> list[Cause]:
    """Causes that name what is hidden: one, or one for each wave."""
    return [c for c in answer.causes if (c.effect, c.joint) == (hidden.answer, hidden.joint)]


def marked_sizes(hidden: Secret, answer: Diagnosis, robot: RobotDescription) -> list[SizeMark]:
    """Sizes of an effect of the library that is named; none where another shape was chosen, or the equation differs."""
    cause = next(iter(_causes(hidden, answer)), None)
    if cause is None or hidden.is_foreign or not _same_shape(hidden, cause, robot):
        return []
    numbers, found = hidden.numbers(robot), []
    for said in cause.parameters:
        known = EFFECTS[hidden.answer].parameters().get(said.name.partition(".")[0])
        if known is None or known.null is None or said.name not in numbers:
            continue
        true = numbers[said.name]
        parts = [f"{known.name}.{axis}" for axis in "xyz"] if known.per == "vector" else [said.name]
        scale = float(np.linalg.norm([numbers[part] - known.null for part in parts]))
        if scale > 0:
            found.append(SizeMark(name=said.name, said=said.value, true=true, interval=said.interval, scale=scale))
    return found


def _same_shape(hidden: Secret, cause: Cause, robot: RobotDescription) -> bool:
    known, numbers = EFFECTS[hidden.answer].parameters(), hidden.numbers(robot)
    for name, value in cause.fixed.items():
        parameter = known.get(name.partition(".")[0])
        told = name in numbers  # an equation of its own may have no such number
        if parameter is None or not told or parameter.null is not None or parameter.role in ("phase", "cycles"):
            continue
        if not np.allclose(value, numbers[name], rtol=_SHAPE, atol=0):
            return False
    return True


def marked_cycles(hidden: Secret, answer: Diagnosis, robot: RobotDescription) -> float | None:
    """Cycles per motor turn in an answer less the true ones, of the wave of the cause that is nearest to the main one.

    None where nothing is periodic, or it is not named.
    """
    known = EFFECTS[hidden.answer].parameters() if hidden.answer else {}
    name = next((p.name for p in known.values() if p.role == "cycles" and p.unit == "1"), None)
    if name is None or name not in (true := hidden.numbers(robot)):
        return None
    said = [{p.name: p.value for p in cause.parameters} | cause.fixed for cause in _causes(hidden, answer)]
    off = [float(numbers[name] - true[name]) for numbers in said if name in numbers]
    return min(off, key=abs, default=None)
