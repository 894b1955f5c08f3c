"""Outcome of the fit of one structure: its numbers with intervals, and what it says of every row."""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from ffgym.core.typed_json import from_json
from ffgym.core.types import Array
from ffgym.diagnosis.tables.structures import ModelStructure

LeftOutBy = Literal["refit", "one step"]
"""Fit without the rows of a place: a search of its own, or one Gauss-Newton step from the optimum, for less work."""


@dataclass(frozen=True, kw_only=True)
class FittedFreeNumber:
    """Free number after the fit."""

    name: str
    value: float
    unit: str
    low: float
    """Lower end of the interval of 90 %, by linear error propagation about the optimum."""
    high: float
    typical: float
    """Value before the fit."""
    spreads: float
    """Distance from the typical value, in standard deviations of the prior."""
    source: str
    """Origin of the prior."""


@dataclass(frozen=True, kw_only=True)
class StructureFit:
    """Structure with its fitted numbers, and what it says of every row."""

    name: str
    title: str
    free_parameters: int
    cost: float
    """Sum of squares at the optimum, priors among them."""
    prior_cost: float
    """Part of it that the distances from typical values have."""
    steps: int
    """Steps of the search."""
    numbers: tuple[FittedFreeNumber, ...]
    x: tuple[float, ...]
    """Free numbers as they were fitted."""
    predicted_mm: tuple[float, ...]
    """Error of each row of the table at the optimum."""
    left_out_mm: tuple[float, ...]
    """Error of each fitted row, predicted without the rows of its place, at the step of the search; nan for others."""
    left_out_by: LeftOutBy
    """Fit that these predictions come from."""
    fingerprint: str
    """Fingerprint of the physics of the fitted machine."""

    @property
    def start(self) -> tuple[tuple[str, float], ...]:
        """Free numbers x by name, for a search of a structure that extends this one."""
        return tuple((number.name, x) for number, x in zip(self.numbers, self.x, strict=True))


def parse_fit(value: Any, where: str) -> StructureFit:
    """Parse a fit that `to_json` wrote."""
    fit: StructureFit = from_json(StructureFit, value, where)
    return fit


def describe_numbers(structure: ModelStructure, x: Array, jacobian: Array) -> tuple[FittedFreeNumber, ...]:
    """Values of the free numbers, with intervals by linear error propagation; priors are rows of the Jacobian."""
    if not len(x):
        return ()
    sigma = np.sqrt(np.diag(np.linalg.inv(jacobian.T @ jacobian)))
    return tuple(
        FittedFreeNumber(
            name=number.name,
            value=number.value(float(at)),
            unit=number.unit,
            low=number.value(float(at - 1.645 * s)),
            high=number.value(float(at + 1.645 * s)),
            typical=number.typical,
            spreads=float(at / number.spread),
            source=number.source,
        )
        for number, at, s in zip(structure.numbers, x, sigma, strict=True)
    )
