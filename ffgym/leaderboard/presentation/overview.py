"""The standings at a glance: a line of dots for each ranked row, one for each speed."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ffgym.leaderboard.comparison.standings import Standings
from ffgym.leaderboard.presentation.svg import COLOURS, svg, text

_SPEEDS = {10.0: "#009E73", 20.0: "#56B4E9", 40.0: "#E69F00", 70.0: "#CC79A7", 100.0: "#D55E00"}
"""Colours by speed [mm/s]; those of the thesis as in other pages."""
_TICKS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0)
"""Shares of the error that may be marked."""


@dataclass(frozen=True, kw_only=True)
class Form:
    """How the picture is laid out [px]."""

    width: int
    left: int
    """Where the axis begins; titles stand before it, or above their line if there is no place."""
    right: int
    """Margin behind the axis."""
    row: int
    """Height of a line."""
    legend: int
    """Between its entries."""

    @property
    def titles_above(self) -> bool:
        """Whether titles stand above their lines."""
        return self.left < 100


WIDE = Form(width=980, left=290, right=30, row=24, legend=110)
PHONE = Form(width=350, left=12, right=14, row=38, legend=60)


def overview(standings: Standings, form: Form) -> str:
    """Share of the zero action's mean error that ranked rows leave at every speed, on a logarithmic axis."""
    lines = standings.ranked
    shares = [[1 - each.reduction for each in line.score.speeds] for line in lines]
    finite = [share for row in shares for share in row if np.isfinite(share) and share > 0]
    if not finite:
        return ""
    low, high = min(*finite, 0.5) / 1.15, max(*finite, 1.0) * 1.15

    def place(share: float) -> float:
        return float(form.left + (form.width - form.left - form.right) * np.log(share / low) / np.log(high / low))

    top, floor = 34, 34 + form.row * len(lines)
    speeds = standings.grid.speeds_mm_s
    parts = [_legend(speeds, form)]
    for tick in (tick for tick in _TICKS if low <= tick <= high):
        colour = COLOURS["soft"] if tick == 1.0 else COLOURS["line"]
        parts.append(f'<path d="M{place(tick):.1f} {top}V{floor}" stroke="{colour}"/>')
        parts.append(text(place(tick), floor + 16, f"{tick:.0%}", anchor="middle"))
    for k, (line, row) in enumerate(zip(lines, shares, strict=True)):
        bottom = top + form.row * (k + 1)
        y = bottom - (9 if form.titles_above else form.row / 2)
        title = f"{line.rank}  {_short(line.row.title)}"
        where = (form.left, y - 10) if form.titles_above else (form.left - 12, y + 4)
        anchor = "start" if form.titles_above else "end"
        parts.append(text(*where, title, anchor=anchor, colour=COLOURS["ink"], size=13))
        known = [(speed, place(share)) for speed, share in zip(speeds, row, strict=True) if share > 0]
        seen = [(speed, x) for speed, x in known if np.isfinite(x)]
        if seen:
            ends = min(x for _, x in seen), max(x for _, x in seen)
            parts.append(f'<path d="M{ends[0]:.1f} {y:g}H{ends[1]:.1f}" stroke="{COLOURS["line"]}"/>')
        parts += [f'<circle cx="{x:.1f}" cy="{y:g}" r="5" fill="{_colour(speed)}"/>' for speed, x in seen]
    middle = (form.left + form.width - form.right) / 2
    parts.append(text(middle, floor + 34, "share of the error that is left (logarithmic)", anchor="middle"))
    return svg(form.width, floor + 42, parts, "Share of the path error that every ranked agent leaves at each speed")


def _legend(speeds: Sequence[float], form: Form) -> str:
    parts = []
    for k, speed in enumerate(speeds):
        x = form.left + 8 + form.legend * k
        words = f"{speed:g} mm/s" if not form.titles_above or k == len(speeds) - 1 else f"{speed:g}"
        parts.append(f'<circle cx="{x}" cy="14" r="5" fill="{_colour(speed)}"/>{text(x + 10, 18, words)}')
    return "".join(parts)


def _colour(speed: float) -> str:
    return _SPEEDS.get(speed, COLOURS["ink"])


def _short(title: str) -> str:
    return title if len(title) <= 42 else title[:41] + "…"
