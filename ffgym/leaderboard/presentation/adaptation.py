"""Curve of adaptation on the page: error left over seconds of robot time, machines apart, and who leaves least when."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import cycle
from math import floor, log10

from ffgym.envs.machines import is_workcell
from ffgym.leaderboard.adaptation.curve import BASELINE, CurvePoint, curve
from ffgym.leaderboard.adaptation.results import AdaptationResults

START = 1.0
"""Left end of the axis of time [s]."""
LEAST = 0.1
"""Lower end of the axis of errors left, or the least error of a machine below it."""
SHARES = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0)
"""Grid lines of the error left."""
COLOURS = ("#4c5a67", "#0b6fb8", "#2a8a4a", "#b3401f", "#7a4fb0", "#8a6a1f", "#c02f7a", "#0e8f9c", "#1a1a1a")
"""Colours of families in their order."""


@dataclass(frozen=True, kw_only=True)
class Axes:
    """Logarithmic axes of the picture, in units of its text, which is 11 high; narrow, so that a phone shows it."""

    last: float
    """Right end [s]."""
    least: float
    """Lower end, as a share; the upper end is 1."""
    width: float = 430.0
    height: float = 330.0
    left: float = 40.0
    right: float = 422.0
    top: float = 8.0
    bottom: float = 294.0

    def across(self, seconds: float) -> float:
        """Place a time [s] on the picture."""
        part = log10(max(seconds, START) / START) / log10(self.last / START)
        return round(self.left + (self.right - self.left) * part, 1)

    def down(self, share: float) -> float:
        """Place an error left on the picture; what is outside of the axis is put on its end."""
        part = log10(min(max(share, self.least), 1.0)) / log10(self.least)
        return round(self.top + (self.bottom - self.top) * part, 1)

    def line(self, times: Sequence[float], shares: Sequence[float]) -> str:
        """Join points to a line, as SVG has it."""
        return " ".join(f"{self.across(t):g},{self.down(share):g}" for t, share in zip(times, shares, strict=True))

    @property
    def seconds(self) -> list[float]:
        """Grid lines of time [s]."""
        return [10.0**k for k in range(floor(log10(self.last)) + 1)]

    @property
    def shares(self) -> list[float]:
        """Grid lines of the error left."""
        return [share for share in SHARES if share >= self.least]


@dataclass(frozen=True, kw_only=True)
class FamilyCurve:
    """One family of adapters in the picture."""

    title: str
    colour: str
    line: str
    """Line of the mean over machines."""
    machines: tuple[str, ...]
    """Line of each machine; none for laws that move nothing."""
    points: tuple[CurvePoint, ...]
    """Points with a mark and an interval; none for laws that move nothing."""


@dataclass(frozen=True, kw_only=True)
class AdaptationPicture:
    """Picture of the curve, and who leaves least at each budget."""

    axes: Axes
    families: tuple[FamilyCurve, ...]
    sentences: tuple[str, ...]
    machines: int
    """Number of workcells."""


def draw_adaptation(results: AdaptationResults, titles: Mapping[str, str]) -> AdaptationPicture | None:
    """Draw the curve of adaptation on all workcells of a result file; None if it has none.

    Args:
        results: runs of adapters on machines.
        titles: titles of adapters by name, in the order of the legend.

    Raises:
        FFGymError: if a machine was not run without compensation.
    """
    machines = tuple(dict.fromkeys(run.machine for run in results.runs if is_workcell(run.machine)))
    curves = {
        title: points
        for name, title in titles.items()
        if name != BASELINE and (points := curve(results.runs, name, machines))
    }
    every = [point for points in curves.values() for point in points]
    if not every:
        return None
    axes = Axes(
        last=max(10 * START, *(point.budget_s for point in every)),
        least=min(LEAST, *(float(point.by_machine.min()) for point in every)),
    )
    families = [
        _make_family(axes, title, colour, points)
        for (title, points), colour in zip(curves.items(), cycle(COLOURS), strict=False)
    ]
    return AdaptationPicture(
        axes=axes, families=tuple(families), sentences=tuple(_say_who_wins(curves)), machines=len(machines)
    )


def _make_family(axes: Axes, title: str, colour: str, points: Sequence[CurvePoint]) -> FamilyCurve:
    """Make the lines of a family; a law that moves nothing is a level line."""
    if points[-1].budget_s == 0:
        level = axes.line([START, axes.last], [points[-1].left] * 2)
        return FamilyCurve(title=title, colour=colour, line=level, machines=(), points=())
    whole = [point for point in points if point.machines == points[0].machines]
    times = [point.budget_s for point in whole]
    rows = range(len(points[0].machines))
    return FamilyCurve(
        title=title,
        colour=colour,
        line=axes.line(times, [point.left for point in whole]),
        machines=tuple(axes.line(times, [float(point.by_machine[row]) for point in whole]) for row in rows),
        points=tuple(whole),
    )


def _say_who_wins(curves: Mapping[str, Sequence[CurvePoint]]) -> list[str]:
    """Say which family leaves least without motion, and then at each budget, until nobody leaves less."""
    sentences: list[str] = []
    reached = 1.0
    for budget in sorted({point.budget_s for points in curves.values() for point in points}):
        left = {title: point for title, points in curves.items() for point in points if point.budget_s == budget}
        title = min(left, key=lambda name: left[name].left)
        best = left[title]
        if best.left >= reached:
            continue
        spread = "" if best.spread is None else f" ({best.spread.low:.1%} to {best.spread.high:.1%} over machines)"
        when = "Without any motion" if budget == 0 else f"After {budget:.3g} s of motion"
        sentences.append(
            f"{when} {title} leaves least: {best.left:.1%}{spread}, "
            f"at most {best.worst:.0%} on any motion of any machine."
        )
        reached = best.left
    if sentences:
        sentences.append("No larger budget of any family left less.")
    return sentences
