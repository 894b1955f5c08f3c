"""Figures that are demanded of a diagnosis in the second exam."""

from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from scripts.exam.figures import Line, none_of, run_of, share
from scripts.exam.marks import Mark
from scripts.exam.sizes import SizeMark

_LOUD = 10.0
"""Loudness from which on an effect must be found."""

_COVERED = (0.85, 0.95)
"""Share of 90 % intervals that are to hold the truth."""

_LEAST = 0.75
"""The same of each effect at least, where there are `_ENOUGH` of them."""

_ENOUGH = 4
"""Sizes of an effect from which on its own share is told."""

_SECONDS = 120.0
"""Longest time of a diagnosis [s]."""


def independent_table(marks: Sequence[Mark]) -> list[Line]:
    """All figures, in the order of the demands."""
    clean = [mark for mark in marks if mark.row == "clean"]
    single = [mark for mark in marks if mark.row == "single"]
    outside = [mark for mark in marks if mark.row == "outside"]
    loud = [mark for mark in single if mark.loudness >= _LOUD]
    return [
        none_of(1, "clean logs named", clean, lambda m: m.verdict in ("named", "partly", "ambiguous")),
        share(1, "clean logs: none", clean, lambda m: m.verdict == "none", 0.95),
        none_of(2, "wrong names", [*single, *outside], lambda m: m.names_wrongly, 0.01),
        share(3, "one effect, 10 and more: right or in the tie", loud, _is_found, 0.9),
        none_of(4, "outside: named", outside, lambda m: m.verdict == "named"),
        share(
            4,
            "outside, 10 and more: right variable or frequency",
            [mark for mark in outside if mark.loudness >= _LOUD],
            lambda m: m.clue_found is True,
            0.8,
        ),
        *_covered(single),
        *run_of(6, marks, marks, _SECONDS),
    ]


def _is_found(mark: Mark) -> bool:
    return mark.outcome in ("right", "surplus", "tie")


def _covered(single: Sequence[Mark]) -> list[Line]:
    """Intervals of the effects that were named, all of them and the effect that does worst."""
    by_effect: dict[str, list[SizeMark]] = defaultdict(list)
    for mark in single:
        if mark.outcome in ("right", "surplus"):
            by_effect[mark.truth[0].answer] += mark.sizes
    sizes = [size for of_one in by_effect.values() for size in of_one]
    covered = float(np.mean([size.is_covered for size in sizes])) if sizes else np.nan
    shares = {
        name: float(np.mean([size.is_covered for size in of_one]))
        for name, of_one in by_effect.items()
        if len(of_one) >= _ENOUGH
    }
    worst = min(shares, key=lambda name: shares[name], default="")
    low, high = _COVERED
    return [
        Line(
            number=5,
            figure="90 % interval covers the size",
            demand=f"{low:.0%} to {high:.0%}",
            got=f"{covered:.1%}" if sizes else "-",
            of=len(sizes),
            is_met=low <= covered <= high if sizes else None,
        ),
        Line(
            number=5,
            figure=f"the same, effect by effect, from {_ENOUGH} on",
            demand=f"all >= {_LEAST:.0%}",
            got=f"least {shares[worst]:.1%}, {worst}" if shares else "-",
            of=len(shares),
            is_met=shares[worst] >= _LEAST if shares else None,
        ),
    ]
