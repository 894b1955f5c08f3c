"""What is believed of parameters before a log is seen."""

from dataclasses import dataclass

from ffgym.core.types import Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Priors:
    """Of all columns, in the units in which they are scaled, shape (P,) each."""

    precision: Array
    low: Array
    high: Array
