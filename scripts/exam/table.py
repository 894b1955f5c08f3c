"""The figures that are demanded of a diagnosis, beside what the marks of an exam come to."""

from collections.abc import Sequence

import numpy as np

from scripts.exam.figures import Line, none_of, run_of, share
from scripts.exam.marks import Mark

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

_SECONDS = 60.0
"""Longest time of a diagnosis [s]."""


def table(marks: Sequence[Mark]) -> list[Line]:
    """All figures, in the order of the demands."""
    singles = [mark for mark in marks if mark.row in ("single", "foreign", "periodic")]
    return [
        none_of(1, "clean logs named", _rows(marks, "clean"), _names),
        *_by_loudness(singles),
        share(
            5,
            "other equation, 5 and more: right effect and joint",
            _louder([mark for mark in singles if any(truth.is_foreign for truth in mark.truth)], 5.0),
            _is_right,
            0.9,
        ),
        *_outside(_louder(_rows(marks, "outside"), 2.0)),
        _cycles(singles),
        *_sizes(_louder(singles, 10.0)),
        *_poor(marks),
        *_pairs(_louder(_rows(marks, "pair"), 10.0)),
        *_gain([mark for mark in _louder(singles, 10.0) if mark.outcome == "right"]),
        *_running(marks),
        none_of(13, "no tracker: wrong named", _rows(marks, "no_tracker"), _is_wrong),
        none_of(13, "no temperature: wrong named", _rows(marks, "no_temperature"), _is_wrong),
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


def _by_loudness(singles: Sequence[Mark]) -> list[Line]:
    """One effect: right and wrong names, the loudest first."""
    lines = []
    for number, (name, low, high), least, most in ((2, BANDS[3], 0.98, 0.0), (3, BANDS[2], 0.92, 0.01)):
        band = _louder(singles, low, high)
        lines += [
            share(number, f"one effect, {name}: right effect and joint first", band, _is_right, least),
            none_of(number, f"one effect, {name}: wrong named", band, _is_wrong, most),
        ]
    name, low, high = BANDS[1]
    faint = _louder(singles, low, high)
    found = share(4, f"one effect, {name}: right or in the tie", faint, lambda m: _is_right(m) or _ties(m), 0.75)
    return [*lines, found, none_of(4, f"one effect, {name}: wrong named", faint, _is_wrong)]


def _ties(mark: Mark) -> bool:
    return mark.outcome == "tie"


def _outside(marks: Sequence[Mark]) -> list[Line]:
    return [
        share(6, "outside, 2 and more: unknown or partly", marks, lambda m: m.verdict in ("unknown", "partly"), 1.0),
        none_of(6, "outside, 2 and more: named", marks, lambda m: m.verdict == "named"),
        share(6, "outside, 2 and more: right variable or frequency", marks, lambda m: m.clue_found is True, 0.8),
    ]


def _cycles(marks: Sequence[Mark]) -> Line:
    told = [mark for mark in marks if mark.cycles_off is not None]
    within = [abs(mark.cycles_off or 0.0) <= _WITHIN for mark in told]
    return Line(
        number=7,
        figure="periodic: cycles per turn",
        demand=f"all within {_WITHIN}",
        got=f"{np.mean(within):.0%}" if told else "-",
        of=len(told),
        is_met=all(within) if told else None,
    )


def _sizes(marks: Sequence[Mark]) -> list[Line]:
    sizes = [size for mark in marks if mark.outcome == "right" for size in mark.sizes]
    close = [size.error <= _WITHIN for size in sizes]
    covered = float(np.mean([size.is_covered for size in sizes])) if sizes else np.nan
    return [
        Line(
            number=8,
            figure="size, 10 and more",
            demand=f"all within {_WITHIN:.0%}",
            got=f"{np.mean(close):.1%}, median error {np.median([s.error for s in sizes]):.1%}" if sizes else "-",
            of=len(sizes),
            is_met=all(close) if sizes else None,
        ),
        Line(
            number=8,
            figure="90 % interval covers the size",
            demand="80 % to 98 %",
            got=f"{covered:.1%}" if sizes else "-",
            of=len(sizes),
            is_met=0.8 <= covered <= 0.98 if sizes else None,
        ),
    ]


def _poor(marks: Sequence[Mark]) -> list[Line]:
    poor = _rows(marks, "poor")
    ambiguous = [mark for mark in poor if mark.verdict == "ambiguous"]
    proposed = [mark for mark in ambiguous if mark.outcome == "tie" and mark.then is not None]
    return [
        none_of(9, "poor logs: wrong named", [*poor, *_rows(marks, "poor_clean")], _poorly_named),
        share(9, "poor logs: the truth is in the tie", ambiguous, _ties, 0.9),
        share(9, "poor logs: the proposed motion resolves it", proposed, lambda m: m.then == "right", 0.9),
    ]


def _poorly_named(mark: Mark) -> bool:
    return mark.names_wrongly or (not mark.truth and mark.verdict == "named")


def _pairs(marks: Sequence[Mark]) -> list[Line]:
    both = ("right", "surplus")
    return [
        share(10, "pairs, each 10 and more: both named", marks, lambda m: m.outcome in both, 0.8),
        none_of(10, "pairs, each 10 and more: wrong named", marks, _is_wrong),
    ]


def _gain(marks: Sequence[Mark]) -> list[Line]:
    gains = [mark.gain for mark in marks if mark.gain is not None]
    left = [gain.leftover for gain in gains]
    tools = np.array([(gain.before, gain.after) for gain in gains]) * 1e6
    return [
        Line(
            number=11,
            figure="energy left on held-out motions, closed loop",
            demand=f"all <= {_LEFT}",
            got=f"median {np.median(left):.2f}, largest {max(left):.2f}" if left else "-",
            of=len(left),
            is_met=max(left) <= _LEFT if left else None,
        ),
        Line(
            number=11,
            figure="tool, simulated and true: before and after, median",
            demand="reported",
            got="{:.1f} to {:.1f} micrometres".format(*np.median(tools, axis=0)) if len(tools) else "-",
            of=len(tools),
            is_met=True if len(tools) else None,
        ),
    ]


def _running(marks: Sequence[Mark]) -> list[Line]:
    return run_of(12, marks, [mark for mark in marks if mark.row not in ("poor", "poor_clean")], _SECONDS)
