"""One figure of an exam, beside what is demanded."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from scripts.exam.marks import Mark

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


def run_of(number: int, marks: Sequence[Mark], timed: Sequence[Mark], limit: float) -> list[Line]:
    """Whether answers are the same twice, and how long they take.

    Args:
        number: of the demand.
        marks: all of them.
        timed: those whose time counts.
        limit: longest time of a diagnosis [s].
    """
    repeated, seconds = [mark for mark in marks if mark.same_bytes is not None], [mark.seconds for mark in timed]
    return [
        share(number, "the same bytes twice", repeated, lambda m: m.same_bytes is True, 1.0),
        Line(
            number=number,
            figure="time of a diagnosis",
            demand=f"<= {limit:.0f} s",
            got=f"median {np.median(seconds):.0f} s, longest {max(seconds):.0f} s" if seconds else "-",
            of=len(seconds),
            is_met=max(seconds) <= limit if seconds else None,
        ),
    ]
