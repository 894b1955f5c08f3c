"""Every effect of the library on every joint that can have it, as columns beside those of the calibration."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ffgym.diagnosis.calibration import BOUND, Doubt
from ffgym.diagnosis.evidence.screen import Candidate, Priors
from ffgym.diagnosis.signatures.column import Column, Parts, together
from ffgym.diagnosis.signatures.variant import step_of
from ffgym.types import Array, IntArray

_WIDE = 10.0
"""Standard deviation of a candidate's parameter in practical steps: as good as free, but not without end."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Candidates:
    """Columns of calibration and effects, scaled to standard deviations and practical steps."""

    doubts: tuple[Doubt, ...]
    columns: tuple[Column, ...]
    """Of effects."""
    groups: tuple[Candidate, ...]
    """Effect, joint and shape, with places among all columns: calibration first."""
    scale: Array
    """Standard deviation or step of each column, in its parameter's unit, shape (P,)."""
    priors: Priors

    @property
    def calibration(self) -> IntArray:
        """Places of the calibration's columns."""
        return np.arange(len(self.doubts))

    @property
    def parts(self) -> list[Parts]:
        """All columns, scaled."""
        plain = [*(doubt.column for doubt in self.doubts), *self.columns]
        return [
            {key: rows * scale for key, rows in column.parts.items()}
            for column, scale in zip(plain, self.scale, strict=True)
        ]

    def first(self, group: Candidate) -> Column:
        """A column of a candidate: all have its effect and joint."""
        return self.columns[int(group.columns[0]) - len(self.doubts)]

    def of(self, group: Candidate) -> list[Column]:
        """All columns of a candidate."""
        return [self.columns[int(i) - len(self.doubts)] for i in group.columns]


def candidates_of(doubts: Sequence[Doubt], columns: Sequence[Column]) -> Candidates:
    """All columns in one order."""
    steps = [abs(step_of(c.effect.parameters()[c.parameter])) for c in columns]
    scale = np.array([*(doubt.sigma for doubt in doubts), *steps])
    n, total = len(doubts), len(doubts) + len(columns)
    groups = []
    for places in together(columns):
        first = columns[places[0]]
        p = first.effect.parameters()[first.parameter]
        groups.append(Candidate(columns=np.array(places) + n, one_sided=len(places) == 1 and p.minimum == p.null))
    low = np.concatenate([np.full(n, -BOUND), np.full(total - n, -np.inf)])
    precision = np.concatenate([np.ones(n), np.full(total - n, _WIDE**-2)])
    return Candidates(
        doubts=tuple(doubts),
        columns=tuple(columns),
        groups=tuple(groups),
        scale=scale,
        priors=Priors(precision=precision, low=low, high=-low),
    )
