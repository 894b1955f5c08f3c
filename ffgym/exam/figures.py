"""One figure of an exam, beside what is demanded."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from ffgym.exam.marks import Mark

Test = Callable[[Mark], bool]


@final
@dataclass(frozen=True, kw_only=True)
class Line:
    """One figure."""

    number: int
    """Row of the table of demands."""
    figure: str
    demand: str
    got: str
    of: int
    """How many answers it is taken from."""
    is_met: bool | None
    """None if there are none."""


def share(number: int, figure: str, marks: Sequence[Mark], test: Test, least: float) -> Line:
    """Share of answers that pass a test, which must be at least so large."""
    passed = np.mean([test(mark) for mark in marks]) if marks else np.nan
    return Line(
        number=number,
        figure=figure,
        demand=f">= {least:.0%}",
        got=f"{passed:.1%}" if marks else "-",
        of=len(marks),
        is_met=bool(passed >= least) if marks else None,
    )


def none_of(number: int, figure: str, marks: Sequence[Mark], test: Test, most: float = 0.0) -> Line:
    """Number of answers that a test finds, which must be no more than a share of them."""
    count = sum(test(mark) for mark in marks)
    return Line(
        number=number,
        figure=figure,
        demand=f"<= {most:.0%}" if most else "0",
        got=f"{count}",
        of=len(marks),
        is_met=count <= most * len(marks) if marks else None,
    )
