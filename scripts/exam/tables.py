"""Figures that are demanded of a diagnosis, beside what the marks of an exam come to."""

from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from scripts.exam.marks import Gain, Mark, SizeMark

Test = Callable[[Mark], bool]

BANDS: tuple[tuple[str, float, float], ...] = (
    ("below 1.3", 1.0, 1.3),
    ("1.3 to 2", 1.3, 2.0),
    ("2 to 10", 2.0, 10.0),
    ("10 and more", 10.0, np.inf),
)
"""Names and ends of the bands of loudness."""

_WITHIN = 0.1
"""Largest relative error of a size, and largest absolute one of cycles per turn."""

_LEFT = 1.5
"""Most energy that causes may leave, in energies of noise and calibration."""

_COVERED = (0.85, 0.95)
"""Share of 90 % intervals that are to hold the truth in the second exam."""

_LEAST = 0.75
"""The same of each effect at least, where there are `_ENOUGH` of them."""

_ENOUGH = 4
"""Sizes of an effect from which on its own share is told."""

_SECONDS, _SECONDS_OF_INDEPENDENT = 60.0, 120.0
"""Longest time of a diagnosis in either exam [s]."""


@dataclass(frozen=True, kw_only=True)
class Line:
    """One figure."""

    number: int
    """Row of the table of demands."""
    figure: str
    demand: str
    got: str
    of: int
    """Number of answers that it is taken from."""
    is_met: bool | None
    """None if there are none."""


def share(number: int, figure: str, marks: Sequence[Mark], test: Test, least: float) -> Line:
    """Share of answers that pass a test, which must be at least so large."""
    passed = _mean([test(mark) for mark in marks])
    return _line(number, figure, f">= {least:.0%}", f"{passed:.1%}", len(marks), bool(passed >= least))


def none_of(number: int, figure: str, marks: Sequence[Mark], test: Test, most: float = 0.0) -> Line:
    """Number of answers that a test finds, which must be no more than a share of them."""
    count = sum(test(mark) for mark in marks)
    met = count <= most * len(marks) if marks else None
    demand = f"<= {most:.0%}" if most else "0"
    return Line(number=number, figure=figure, demand=demand, got=f"{count}", of=len(marks), is_met=met)


def _line(number: int, figure: str, demand: str, got: str, of: int, is_met: bool) -> Line:
    """A figure of `of` answers; "-" and neither met nor missed if there are none."""
    met = is_met if of else None
    return Line(number=number, figure=figure, demand=demand, got=got if of else "-", of=of, is_met=met)


def table(marks: Sequence[Mark]) -> list[Line]:
    """All figures of the first exam, in the order of the demands."""
    singles = _rows(marks, "single", "foreign", "periodic")
    loud = _louder(singles, 10.0)
    foreign = [mark for mark in singles if any(truth.is_foreign for truth in mark.truth)]
    lines = [none_of(1, "clean logs named", _rows(marks, "clean"), _names)]
    # one effect: right and wrong names, the loudest first
    for number, (name, low, high), least, most in ((2, BANDS[3], 0.98, 0.0), (3, BANDS[2], 0.92, 0.01)):
        band = _louder(singles, low, high)
        lines.append(share(number, f"one effect, {name}: right effect and joint first", band, _is_right, least))
        lines.append(none_of(number, f"one effect, {name}: wrong named", band, _is_wrong, most))
    name, low, high = BANDS[1]
    faint, outside = _louder(singles, low, high), _louder(_rows(marks, "outside"), 2.0)
    poor, pairs = _rows(marks, "poor"), _louder(_rows(marks, "pair"), 10.0)
    ambiguous = [mark for mark in poor if mark.verdict == "ambiguous"]
    proposed = [mark for mark in ambiguous if mark.outcome == "tie" and mark.then is not None]
    cycles = [abs(mark.cycles_off) <= _WITHIN for mark in singles if mark.cycles_off is not None]
    loose = "outside, 2 and more"
    return [
        *lines,
        share(4, f"one effect, {name}: right or in the tie", faint, lambda m: _is_right(m) or _ties(m), 0.75),
        none_of(4, f"one effect, {name}: wrong named", faint, _is_wrong),
        share(5, "other equation, 5 and more: right effect and joint", _louder(foreign, 5.0), _is_right, 0.9),
        share(6, f"{loose}: unknown or partly", outside, lambda m: m.verdict in ("unknown", "partly"), 1.0),
        none_of(6, f"{loose}: named", outside, lambda m: m.verdict == "named"),
        share(6, f"{loose}: right variable or frequency", outside, lambda m: m.clue_found is True, 0.8),
        _line(
            7,
            "periodic: cycles per turn",
            f"all within {_WITHIN}",
            f"{_mean(cycles):.0%}",
            len(cycles),
            all(cycles),
        ),
        *_sizes([size for mark in loud if mark.outcome == "right" for size in mark.sizes]),
        none_of(9, "poor logs: wrong named", [*poor, *_rows(marks, "poor_clean")], _poorly_named),
        share(9, "poor logs: the truth is in the tie", ambiguous, _ties, 0.9),
        share(9, "poor logs: the proposed motion resolves it", proposed, lambda m: m.then == "right", 0.9),
        share(10, "pairs, each 10 and more: both named", pairs, lambda m: m.outcome in ("right", "surplus"), 0.8),
        none_of(10, "pairs, each 10 and more: wrong named", pairs, _is_wrong),
        *_gain([mark.gain for mark in loud if mark.outcome == "right" and mark.gain is not None]),
        *_run(12, marks, [mark for mark in marks if not mark.row.startswith("poor")], _SECONDS),
        none_of(13, "no tracker: wrong named", _rows(marks, "no_tracker"), _is_wrong),
        none_of(13, "no temperature: wrong named", _rows(marks, "no_temperature"), _is_wrong),
    ]


def independent_table(marks: Sequence[Mark]) -> list[Line]:
    """All figures of the second exam, in the order of the demands."""
    clean, single, outside, arm, blind = (
        _rows(marks, row) for row in ("clean", "single", "outside", "arm", "arm_blind")
    )
    loud, strange = _louder(single, 10.0), _louder(outside, 10.0)
    return [
        none_of(1, "clean logs named", clean, _names),
        share(1, "clean logs: none", clean, lambda m: m.verdict == "none", 0.95),
        none_of(2, "wrong names", [*single, *outside], _is_wrong, 0.01),
        share(
            3,
            "one effect, 10 and more: right or in the tie",
            loud,
            lambda m: m.outcome in ("right", "surplus", "tie"),
            0.9,
        ),
        none_of(4, "outside: named", outside, lambda m: m.verdict == "named"),
        share(4, "outside, 10 and more: right variable or frequency", strange, lambda m: m.clue_found is True, 0.8),
        *_count_covered(single),
        *_run(6, marks, marks, _SECONDS_OF_INDEPENDENT),
        share(
            7,
            "friction behind the elasticity, 10 and more: right alone",
            _louder(arm, 10.0),
            lambda m: m.outcome == "right",
            0.9,
        ),
        none_of(7, "friction behind the elasticity: wrong named", [*arm, *blind], _is_wrong),
        none_of(7, "friction behind the elasticity, no tracker: named", blind, lambda m: m.verdict == "named"),
    ]


def _rows(marks: Sequence[Mark], *rows: str) -> list[Mark]:
    return [mark for mark in marks if mark.row in rows]


def _louder(marks: Sequence[Mark], low: float, high: float = np.inf) -> list[Mark]:
    return [mark for mark in marks if low <= mark.loudness < high]


def _names(mark: Mark) -> bool:
    return mark.verdict in ("named", "partly", "ambiguous")


def _is_right(mark: Mark) -> bool:
    return mark.first_is_right and mark.verdict != "ambiguous"


def _is_wrong(mark: Mark) -> bool:
    return mark.names_wrongly


def _poorly_named(mark: Mark) -> bool:
    return mark.names_wrongly or (not mark.truth and mark.verdict == "named")


def _ties(mark: Mark) -> bool:
    return mark.outcome == "tie"


def _mean(values: Sequence[bool]) -> float:
    return float(np.mean(values)) if values else np.nan


def _median(values: Sequence[float]) -> float:
    return float(np.median(values)) if values else np.nan


def _sizes(sizes: Sequence[SizeMark]) -> list[Line]:
    close, covered = [size.error <= _WITHIN for size in sizes], _mean([size.is_covered for size in sizes])
    got = f"{_mean(close):.1%}, median error {_median([size.error for size in sizes]):.1%}"
    met = 0.8 <= covered <= 0.98
    return [
        _line(8, "size, 10 and more", f"all within {_WITHIN:.0%}", got, len(sizes), all(close)),
        _line(8, "90 % interval covers the size", "80 % to 98 %", f"{covered:.1%}", len(sizes), met),
    ]


def _gain(gains: Sequence[Gain]) -> list[Line]:
    left = [gain.leftover for gain in gains]
    most = max(left, default=np.nan)
    before, after = (1e6 * _median([getattr(gain, when) for gain in gains]) for when in ("before", "after"))
    got, tool = f"median {_median(left):.2f}, largest {most:.2f}", f"{before:.1f} to {after:.1f} micrometres"
    what, met = "energy left on held-out motions, closed loop", bool(most <= _LEFT)
    return [
        _line(11, what, f"all <= {_LEFT}", got, len(left), met),
        _line(11, "tool, simulated and true: before and after, median", "reported", tool, len(left), True),
    ]


def _run(number: int, marks: Sequence[Mark], timed: Sequence[Mark], limit: float) -> list[Line]:
    """Tell whether answers are the same twice, and how long those of `timed` take, of `limit` [s] at most."""
    repeated, seconds = [mark for mark in marks if mark.same_bytes is not None], [mark.seconds for mark in timed]
    most = max(seconds, default=np.nan)
    got = f"median {_median(seconds):.0f} s, longest {most:.0f} s"
    return [
        share(number, "the same bytes twice", repeated, lambda m: m.same_bytes is True, 1.0),
        _line(number, "time of a diagnosis", f"<= {limit:.0f} s", got, len(seconds), bool(most <= limit)),
    ]


def _count_covered(single: Sequence[Mark]) -> list[Line]:
    """Intervals of the effects that were named, all of them and the effect that does worst."""
    by_effect: dict[str, list[SizeMark]] = defaultdict(list)
    for mark in single:
        if mark.outcome in ("right", "surplus"):
            by_effect[mark.truth[0].answer] += mark.sizes
    sizes = [size for of_one in by_effect.values() for size in of_one]
    covered = _mean([size.is_covered for size in sizes])
    shares = {
        name: _mean([size.is_covered for size in of_one])
        for name, of_one in by_effect.items()
        if len(of_one) >= _ENOUGH
    }
    worst = min(shares, key=lambda name: shares[name], default="")
    least, (low, high) = shares.get(worst, np.nan), _COVERED
    each, got = f"the same, effect by effect, from {_ENOUGH} on", f"least {least:.1%}, {worst}"
    demand, met = f"{low:.0%} to {high:.0%}", low <= covered <= high
    return [
        _line(5, "90 % interval covers the size", demand, f"{covered:.1%}", len(sizes), met),
        _line(5, each, f"all >= {_LEAST:.0%}", got, len(shares), least >= _LEAST),
    ]
