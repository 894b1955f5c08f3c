"""Forms of dependence: families of columns fitted by least squares, and functions of one variable among them."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from itertools import permutations
from typing import Literal, final

import numpy as np

from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.patterns.rows import PatternRows
from ffgym.diagnosis.settings import settings


class DependenceForm(ABC):
    """One form of dependence."""

    joint: int | None
    """Joint whose variable it is; None for time."""
    own_only: bool
    """True if only residuals of that joint, and of the tool, may depend on it."""

    def may_act_on(self, rows: PatternRows, component: int) -> bool:
        """Tell whether a component of a channel may depend on it."""
        return not self.own_only or rows.channel == "tool" or self.joint == component

    @abstractmethod
    def complexity(self, rows: PatternRows) -> int:
        """Count the numbers that are fitted."""


class Periodic(DependenceForm):
    """A form with a frequency that must be found in the residual first."""

    @abstractmethod
    def search(self, rows: PatternRows, values: Array, train: BoolArray) -> list[float] | None:
        """Search the frequency that explains most of each column of values (R, C) in the rows of `train` (R,)."""

    @abstractmethod
    def refine(self, rows: PatternRows, values: Array, frequency: float) -> float:
        """Refine a frequency to the one nearby that explains most of `values` (R,) in all rows."""

    @abstractmethod
    def columns(self, rows: PatternRows, frequency: float) -> Array:
        """Compute its columns (R, P), of size about 1, not centred."""


def fit_columns(columns: Array, values: Array) -> Array:
    """Fit coefficients (P, ...) of centred columns (R, P) to values (R, ...)."""
    gram: Array = columns.T @ columns + settings().patterns.prior_rows * np.eye(columns.shape[1])
    return np.asarray(np.linalg.solve(gram, columns.T @ values), dtype=np.float64)


Variable = Literal[
    "angle",
    "speed",
    "size of speed",
    "acceleration",
    "load",
    "temperature",
    "travel",
    "rest",
    "time",
    "way",
    "power",
    "none",
]
"""Variable that a function depends on; `none` is a constant, which only makes sense times a sign."""

COARSE, FINE = 8, 40
"""Knots of a smooth function, and of one with a local bump; chosen: 40 over the range of a joint's large motions tell
a worn spot of a tooth or two, and a quarter of a second in ten."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class VariableFunction(DependenceForm):
    """A function of a variable of one joint, linear between knots; maybe times the sign of the speed of a joint."""

    variable: Variable
    joint: int | None
    signed: int | None = None
    """Joint whose sign it goes with; None for a plain function."""
    knots: int = COARSE
    """2 is a straight line."""
    evenly: bool = False
    """Knots at even values instead of even shares of the rows."""
    own_only: bool = False

    def may_act_on(self, rows: PatternRows, component: int) -> bool:
        """Tell whether a component may depend on it; friction by another joint's state shows in its own joint."""
        if self.signed not in (None, self.joint):
            return rows.channel != "tool" and component == self.signed
        return super().may_act_on(rows, component)

    def columns(self, rows: PatternRows) -> Array:
        """Compute its columns (R, P), of size about 1, not centred."""
        if self.variable == "time" or self.joint is None:
            values = rows.t
        elif self.variable == "none":
            values = np.zeros(len(rows.t))
        else:
            values = rows.did[self.variable][:, self.joint]
        if self.variable == "load" and self.signed is not None:
            values = np.abs(values)  # friction grows with the size of a load
        hats = make_hats(values, self.knots, evenly=self.evenly)
        return hats if self.signed is None else hats * rows.did["sign"][:, self.signed, None]

    def complexity(self, rows: PatternRows) -> int:
        """Count the knots; a constant has one number."""
        return 1 if self.variable == "none" else self.knots


def make_hats(values: Array, knots: int, *, evenly: bool) -> Array:
    """Compute hat functions (R, P) of values (R,), whose sum is 1; constant values give one column of ones."""
    low, high = values.min(), values.max()
    if high - low <= 1e-9 * max(abs(low), abs(high)):
        return np.ones((len(values), 1))
    places = np.linspace(0.0, 1.0, knots)
    at = low + places * (high - low) if evenly else np.unique(np.quantile(values, places))
    left = np.clip(np.searchsorted(at, values, side="right") - 1, 0, len(at) - 2)
    share = (values - at[left]) / (at[left + 1] - at[left])
    columns = np.zeros((len(values), len(at)))
    columns[np.arange(len(values)), left] = 1.0 - share
    columns[np.arange(len(values)), left + 1] = share
    return columns


def list_functions(n_joints: int) -> list[VariableFunction]:
    """List all functions: of time, of the variables of each joint, and of one joint for the friction of another."""
    plain: list[Variable] = ["speed", "size of speed", "acceleration", "load"]
    own: list[Variable] = ["temperature", "travel", "rest", "time"]
    of_other: list[Variable] = ["size of speed", "load", "angle"]
    # time since a motion began, the same in all motions, whatever they do
    found = [VariableFunction(variable="time", joint=None, knots=knots, evenly=True) for knots in (COARSE, FINE)]
    # functions of a joint's own variables, without and with the sign of its speed
    for j in range(n_joints):
        found += [
            VariableFunction(variable="none", joint=j, signed=j),
            *(VariableFunction(variable=v, joint=j) for v in plain),
            *(
                VariableFunction(variable="angle", joint=j, knots=knots, evenly=knots == FINE)
                for knots in (2, COARSE, FINE)
            ),
            VariableFunction(variable="angle", joint=j, signed=j),
            VariableFunction(variable="angle", joint=j, signed=j, knots=FINE, evenly=True, own_only=True),
            *(
                VariableFunction(variable=v, joint=j, signed=j, own_only=True)
                for v in ("size of speed", "load", "power")
            ),
            *(VariableFunction(variable=v, joint=j, own_only=True) for v in ("way", "power")),
            VariableFunction(variable="way", joint=j, signed=j, own_only=True),
            *(VariableFunction(variable=v, joint=j, signed=j, knots=_count_knots(v), own_only=True) for v in own),
            *(VariableFunction(variable=v, joint=j, knots=_count_knots(v), own_only=True) for v in own[:-1]),
        ]
    # friction of a joint that depends on the motion of another
    for j, other in permutations(range(n_joints), 2):
        found += [VariableFunction(variable=v, joint=other, signed=j) for v in of_other]
    return found


def _count_knots(variable: Variable) -> int:
    """Count knots: a straight line in what hardly changes during a motion, as a curve would fit each motion alone."""
    return 2 if variable in ("temperature", "time") else COARSE
