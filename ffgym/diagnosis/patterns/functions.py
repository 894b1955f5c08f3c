"""Functions of one variable, plain or times the sign of a speed, as conditional means between knots."""

from dataclasses import dataclass
from typing import Literal, final

import numpy as np

from ffgym.diagnosis.patterns.candidate import Fixed
from ffgym.diagnosis.patterns.rows import Rows
from ffgym.diagnosis.result import PatternKind
from ffgym.types import Array

Variable = Literal[
    "angle", "speed", "size of speed", "acceleration", "load", "temperature", "travel", "rest", "time", "none"
]
"""What a function depends on; `none` is a constant, which only makes sense times a sign."""

COARSE, FINE = 8, 40
"""Knots of a smooth function, and of one with a local bump; chosen: 40 over the range of a joint's large motions tell
a worn spot of a tooth or two."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Function(Fixed):
    """A function of a variable of one joint, linear between knots; with `signed`, times the sign of its speed."""

    variable: Variable
    joint: int | None
    signed: bool = False
    knots: int = COARSE
    """2 is a straight line."""
    evenly: bool = False
    """Knots at even values instead of even shares of the rows."""
    own_only: bool = False

    @property
    def kind(self) -> PatternKind:
        """See base class."""
        return "sign-locked function" if self.signed else "function"

    def columns(self, rows: Rows) -> Array:
        """See base class."""
        hats = hat_columns(self._values(rows), self.knots, evenly=self.evenly)
        return hats * rows.did.sign[:, self.joint, None] if self.signed and self.joint is not None else hats

    def complexity(self, rows: Rows) -> int:
        """See base class."""
        return 1 if self.variable == "none" else self.knots

    def _values(self, rows: Rows) -> Array:
        if self.variable == "time" or self.joint is None:
            return rows.did.t
        j, did = self.joint, rows.did
        match self.variable:
            case "none":
                return np.zeros(len(did.t))
            case "size of speed":
                return np.abs(did.speed[:, j])
            case "load" if self.signed:  # friction grows with the size of a load
                return np.abs(did.load[:, j])
            case other:
                values: Array = getattr(did, other)[:, j]
                return values


def hat_columns(values: Array, knots: int, *, evenly: bool) -> Array:
    """Hat functions (R, P) of values (R,), whose sum is 1; constant values give one column of ones."""
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


def functions_of(joint: int) -> list[Function]:
    """All functions of the variables of one joint."""
    plain: list[Variable] = ["speed", "size of speed", "acceleration", "load"]
    own: list[Variable] = ["temperature", "travel", "rest", "time"]
    return [
        Function(variable="none", joint=joint, signed=True),
        *(Function(variable=variable, joint=joint) for variable in plain),
        *(Function(variable="angle", joint=joint, knots=knots, evenly=knots == FINE) for knots in (2, COARSE, FINE)),
        Function(variable="angle", joint=joint, signed=True, evenly=False),
        Function(variable="angle", joint=joint, signed=True, knots=FINE, evenly=True, own_only=True),
        *(Function(variable=v, joint=joint, signed=True, own_only=True) for v in ("size of speed", "load")),
        *(Function(variable=v, joint=joint, signed=True, knots=_knots(v), own_only=True) for v in own),
        *(Function(variable=v, joint=joint, knots=_knots(v), own_only=True) for v in ("temperature", "travel", "rest")),
    ]


def _knots(variable: Variable) -> int:
    """A straight line in what hardly changes during a motion: a freer curve could give each motion its own value."""
    return 2 if variable in ("temperature", "time") else COARSE
