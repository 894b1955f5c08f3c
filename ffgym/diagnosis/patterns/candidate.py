"""What a residual may depend on: a family of forms, each a few columns that are fitted by least squares."""

from abc import ABC, abstractmethod

import numpy as np

from ffgym.diagnosis.patterns.rows import Rows
from ffgym.types import Array, BoolArray

PRIOR_ROWS = 3.0
"""Rows of zero that are added to the fit of each column, so that one seen in few rows says little; chosen: far less
than a block has."""


class Candidate(ABC):
    """One form of dependence."""

    joint: int | None
    """Whose variable it is; None for time."""
    own_only: bool
    """Whether only residuals of that joint, and of the tool, may depend on it."""

    @property
    @abstractmethod
    def searches(self) -> bool:
        """Whether a frequency must be found in the residual first."""

    def search(self, rows: Rows, values: Array, train: BoolArray) -> float:
        """Frequency that explains most of `values` (R,) in the rows of `train` (R,)."""
        raise NotImplementedError(f"{type(self).__name__} has no frequency.")

    @abstractmethod
    def columns(self, rows: Rows, frequency: float | None) -> Array:
        """Its columns (R, P), of size about 1, not centred."""

    @abstractmethod
    def complexity(self, rows: Rows) -> int:
        """Number of what is fitted."""


def fit(columns: Array, values: Array) -> Array:
    """Coefficients (P, C) of centred columns (R, P) for values (R, C)."""
    gram = columns.T @ columns
    gram[np.diag_indices_from(gram)] += PRIOR_ROWS
    coefficients: Array = np.linalg.solve(gram, columns.T @ values)
    return coefficients
