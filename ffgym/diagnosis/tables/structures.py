"""Structures of the model: what a robot may be beside its description, each with a few free numbers and their priors.

A structure is a list of parts. A part has free numbers and the change that they make to a candidate: the machine, and
the friction that its controller knows. New structures come from new parts; pairs are written as `one+other`.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.effects import Effect
from ffgym.robot import RobotDescription
from ffgym.robot.friction import LuGreParameters
from ffgym.simulation.plant import Machine


@dataclass(frozen=True, kw_only=True)
class CandidateModel:
    """Machine that a structure makes of a robot, and what its controller knows."""

    robot: RobotDescription
    effects: tuple[Effect, ...] = ()
    known: LuGreParameters
    """Friction that the laws of the controller are computed from."""

    @property
    def machine(self) -> Machine:
        """The machine that is simulated."""
        return Machine(robot=self.robot, effects=self.effects)

    def with_friction(self, **factors: float | Array) -> "CandidateModel":
        """Return the candidate with friction that is larger by factors (or (N,)), as its controller knows, too."""
        robot = replace(self.robot, friction=self.robot.friction.scale(**factors))
        return replace(self, robot=robot, known=self.known.scale(**factors))


@dataclass(frozen=True, kw_only=True)
class FreeNumber:
    """Free number x of a structure with its prior; 0 is its typical value, and its standard deviation the spread."""

    name: str
    typical: float
    """Value at x = 0."""
    spread: float
    """Standard deviation of x."""
    unit: str = "1"
    source: str
    """Origin of typical value and spread."""
    scale: Literal["log", "share"] = "log"
    """A factor exp(x) on the typical value, or a share between 0 and 1 whose logit is moved by x."""
    reach: float = 3.0
    """Largest distance from the typical value, in spreads."""

    def value(self, x: float) -> float:
        """Compute the value at x."""
        if self.scale == "log":
            return float(self.typical * np.exp(x))
        return float(1 / (1 + (1 / self.typical - 1) * np.exp(-x)))


Values = Mapping[str, float]
Change = Callable[[CandidateModel, Values], CandidateModel]


@dataclass(frozen=True, kw_only=True)
class StructurePart:
    """Change of a model with its free numbers."""

    name: str
    title: str
    numbers: tuple[FreeNumber, ...]
    change: Change
    """Function of a candidate and the values of the numbers by name."""


@dataclass(frozen=True, kw_only=True)
class ModelStructure:
    """Structure of the model: parts that are fitted together."""

    parts: tuple[StructurePart, ...]

    @property
    def name(self) -> str:
        """Name in files and on command lines; the part 'numbers', which most have, is left out beside others."""
        own = [part.name for part in self.parts if part.name != "numbers"]
        return "+".join(own) or ("numbers" if self.parts else "description")

    @property
    def title(self) -> str:
        """Title for people."""
        own = [part.title for part in self.parts if part.name != "numbers"]
        return ", ".join(own) or ("numbers only" if self.parts else "as described")

    @property
    def numbers(self) -> tuple[FreeNumber, ...]:
        """Free numbers of all parts, in their order."""
        return tuple(number for part in self.parts for number in part.numbers)

    @property
    def spread(self) -> Array:
        """Standard deviations of the free numbers, shape (K,)."""
        return np.array([number.spread for number in self.numbers])

    @property
    def reach(self) -> Array:
        """Largest distances of the free numbers from 0, shape (K,)."""
        return np.array([number.reach * number.spread for number in self.numbers])

    def values(self, x: Array) -> dict[str, float]:
        """Values of the free numbers `x` (K,), by name."""
        return {number.name: number.value(float(value)) for number, value in zip(self.numbers, x, strict=True)}

    def candidate(self, robot: RobotDescription, x: Array) -> CandidateModel:
        """Return the candidate of a robot with free numbers `x` (K,)."""
        return self.candidate_with(robot, self.values(x))

    def candidate_with(self, robot: RobotDescription, values: Mapping[str, float]) -> CandidateModel:
        """Return the candidate of a robot with values of the free numbers by name."""
        found = CandidateModel(robot=robot, known=robot.with_arm_share(None).friction)
        for part in self.parts:
            found = part.change(found, values)
        return found


def extends(one: str, other: str) -> bool:
    """Tell whether a structure has all parts of another, and more."""
    mine, theirs = ({*name.split("+")} - {"numbers", "description"} for name in (one, other))
    return one != other and other != "description" and mine > theirs


def main_motors(robot: RobotDescription) -> Array:
    """Tell the main motors of a robot from those of its wrist by the size of their rotors, shape (N,), bool."""
    inertia = robot.drive.rotor_inertia
    ordered = np.sort(np.unique(inertia))
    if len(ordered) == 1:
        return np.ones(robot.n_joints, dtype=np.bool_)
    # two sizes of motors: above and below the widest gap between sizes
    low, high = max(pairwise(ordered), key=lambda pair: pair[1] / pair[0])
    return np.asarray(inertia > np.sqrt(low * high))


def combine(parts: Sequence[StructurePart]) -> ModelStructure:
    """Make the structure of parts.

    Raises:
        FFGymError: if two parts have a free number of the same name.
    """
    names = [number.name for part in parts for number in part.numbers]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise FFGymError(f"Parts {[part.name for part in parts]} share the free numbers {twice}; rename them.")
    return ModelStructure(parts=tuple(parts))
