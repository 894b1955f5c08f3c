"""What a residual may depend on: a family of forms, each a few columns that are fitted by least squares."""

from abc import ABC, abstractmethod

import numpy as np

from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.patterns.rows import Rows
from ffgym.diagnosis.result import PatternKind

PRIOR_ROWS = 3.0
"""Rows of zero that are added to the fit of each column, so that one seen in few rows says little; chosen: far less
than a block has."""


class Candidate(ABC):
    """One form of dependence."""

    joint: int | None
    """Whose variable it is; None for time."""
    own_only: bool
    """Whether only residuals of that joint, and of the tool, may depend on it."""

    def may_act_on(self, rows: Rows, component: int) -> bool:
        """Whether a component of a channel may depend on it."""
        return not self.own_only or rows.channel == "tool" or self.joint == component

    @property
    @abstractmethod
    def kind(self) -> PatternKind:
        """What kind of pattern it is."""

    @abstractmethod
    def complexity(self, rows: Rows) -> int:
        """Number of what is fitted."""


class Fixed(Candidate):
    """A form whose columns follow from the motion alone."""

    @abstractmethod
    def columns(self, rows: Rows) -> Array:
        """Its columns (R, P), of size about 1, not centred."""


class Periodic(Candidate):
    """A form with a frequency that must be found in the residual first."""

    @abstractmethod
    def search(self, rows: Rows, values: Array, train: BoolArray) -> list[float] | None:
        """Frequency that explains most of each column of values (R, C) in the rows of `train` (R,), if it has one."""

    @abstractmethod
    def refine(self, rows: Rows, values: Array, frequency: float) -> float:
        """The frequency near a found one that explains most of `values` (R,) in all rows."""

    @abstractmethod
    def columns(self, rows: Rows, frequency: float) -> Array:
        """Its columns (R, P), of size about 1, not centred."""


def fit(columns: Array, values: Array) -> Array:
    """Coefficients (P, ...) of centred columns (R, P) for values (R, ...)."""
    gram: Array = columns.T @ columns + PRIOR_ROWS * np.eye(columns.shape[1])
    return np.asarray(np.linalg.solve(gram, columns.T @ values), dtype=np.float64)
