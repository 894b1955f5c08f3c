"""Numbers of the leaderboard as text of table cells, with the values that they are sorted by."""

from dataclasses import dataclass
from math import isfinite, isinf

from ffgym.leaderboard.comparison.statistics import Interval
from ffgym.report.table import Cell

STOPPED = "stopped"
"""Text in place of the error of a robot that stopped."""
_FAR = 1e300
"""Value that sorts in place of infinity, which JSON lacks."""
Sortable = float | str | None


@dataclass(frozen=True, kw_only=True)
class Figure(Cell):
    """One cell of the table."""

    sort: Sortable = None
    """Value that the column is sorted by; None goes last in either direction."""
    bar: float | None = None
    """Length of a bar behind the text, 0 to 1."""


NOTHING = Figure(text="–")
"""Cell of a row without such a figure."""


def length(value_um: float, spread: Interval | None = None) -> Figure:
    """Format an error [um], with its interval."""
    return Figure(text=digits(value_um), detail=between(spread), sort=sortable(value_um))


def length_with_change(value_um: float, reduction: float) -> Figure:
    """Format an error [um], and its change against the zero action."""
    return Figure(text=digits(value_um), detail=change(-reduction), sort=sortable(value_um))


def share(value: float, spread: Interval | None = None, *, bar: bool = False) -> Figure:
    """Format a share in percent, with its interval."""
    scaled = None if spread is None else Interval(spread.low * 100, spread.high * 100)
    return Figure(
        text=digits(value * 100),
        detail=between(scaled),
        sort=sortable(value),
        bar=min(value, 1.0) if bar else None,
    )


def digits(value: float) -> str:
    """Format a number with three digits, or all before the point."""
    if not isfinite(value):
        return STOPPED
    size = abs(value)
    return f"{value:,.0f}" if size >= 99.95 else f"{value:.1f}" if size >= 9.995 else f"{value:.2f}"


def between(spread: Interval | None) -> str:
    """Format an interval; empty without randomness."""
    return "" if spread is None else f"[{digits(spread.low)}, {digits(spread.high)}]"


def change(value: float) -> str:
    """Format a change in percent with its sign; -100 only for all. Empty without change, or if the robot stopped."""
    if isinf(value) or abs(value) < 1e-9:
        return ""
    shown = 1 if -1 < value <= -0.98 else 0
    text = f"{value:+.{shown}%}"
    return "±0%" if text in ("+0%", "-0%") else text.replace("-", "−")


def duration(seconds: float) -> str:
    """Format a time in seconds, minutes or hours."""
    if seconds < 120:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 7200 else f"{seconds / 3600:.1f} h"


def count(value: float) -> str:
    """Format a whole number, large ones in short."""
    if value >= 1e6:
        return f"{value / 1e6:.3g} M"
    return f"{value / 1e3:.3g} k" if value >= 1e4 else f"{value:.0f}"


def sortable(value: float) -> float:
    """Return a number that JSON can hold, rounded so that pages stay small."""
    return float(f"{value:.6g}") if isfinite(value) else _FAR if value > 0 else -_FAR
