"""Pictures as SVG inside a page, drawn from numbers alone; titles of agents are escaped."""

from collections.abc import Sequence
from html import escape

import numpy as np
from numpy.typing import ArrayLike

from ffgym.leaderboard.comparison.standings import Standings

COLOURS = {"zero": "#E69F00", "own": "#0072B2", "ink": "#1c2430", "soft": "#5a6472", "line": "#d9dee5"}
"""Of lines and words; shades of Okabe and Ito on the greys of the pages."""
_SPEEDS = {10.0: "#009E73", 20.0: "#56B4E9", 40.0: "#E69F00", 70.0: "#CC79A7", 100.0: "#D55E00"}
"""Colours by speed [mm/s]; those of the thesis as in other pages."""
_LEFT, _WIDTH, _ROW, _RIGHT = 290, 980, 24, 30
"""Of the overview: place for titles, whole width, height of a line, margin [px]."""
_TICKS = (0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0)
"""Shares of the error that may be marked."""


def number(value: float) -> str:
    """A number of a picture, with three digits behind the point at most."""
    text = f"{value:.3f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def polyline(points: ArrayLike, colour: str, *, width: float, dash: str = "") -> str:
    """Line through points, shape (T, 2), y upwards, whose width does not grow with the picture."""
    text = " ".join(f"{number(x)},{number(-y)}" for x, y in np.asarray(points, dtype=float))
    dashes = f' stroke-dasharray="{dash}"' if dash else ""
    return (
        f'<polyline points="{text}" fill="none" stroke="{colour}" stroke-width="{width:g}"{dashes} '
        'stroke-linejoin="round" vector-effect="non-scaling-stroke"/>'
    )


def learning_curve(points: Sequence[tuple[float, float]]) -> str:
    """Mean reward per step over steps of training; empty if there are fewer than two points."""
    if len(points) < 2:
        return ""
    steps, rewards = np.asarray(points, dtype=float).T
    width, height, left, bottom = 420.0, 200.0, 58.0, 34.0
    low, high = float(rewards.min()), float(rewards.max())
    high = high if high > low else low + 1.0
    x = left + (width - left - 14) * (steps - steps[0]) / max(float(np.ptp(steps)), 1.0)
    y = 12 + (height - bottom - 12) * (high - rewards) / (high - low)
    floor = height - bottom
    parts = [
        f'<path d="M{left:g} 12V{floor:g}H{width - 14:g}" fill="none" stroke="{COLOURS["soft"]}"/>',
        polyline(np.stack([x, -y], axis=1), COLOURS["own"], width=1.8),
        _text(left - 6, 16, f"{high:.3g}", anchor="end"),
        _text(left - 6, floor, f"{low:.3g}", anchor="end"),
        _text(left, floor + 15, f"{steps[0]:,.0f}"),
        _text(width - 14, floor + 15, f"{steps[-1]:,.0f}", anchor="end"),
        _text((left + width) / 2, floor + 29, "control steps of training", anchor="middle"),
    ]
    label = f"Learning curve: mean reward per step from {rewards[0]:.3g} to {rewards[-1]:.3g}"
    return _svg(width, height, parts, label)


def overview(standings: Standings) -> str:
    """Share of the zero action's mean error that ranked rows leave at every speed, on a logarithmic axis."""
    lines = standings.ranked
    shares = [[1 - each.reduction for each in line.score.speeds] for line in lines]
    finite = [share for row in shares for share in row if np.isfinite(share) and share > 0]
    if not finite:
        return ""
    low, high = min(*finite, 0.5) / 1.15, max(*finite, 1.0) * 1.15

    def place(share: float) -> float:
        return float(_LEFT + (_WIDTH - _LEFT - _RIGHT) * np.log(share / low) / np.log(high / low))

    top, floor = 34, 34 + _ROW * len(lines)
    speeds = standings.grid.speeds_mm_s
    parts = [_legend(speeds)]
    for tick in (tick for tick in _TICKS if low <= tick <= high):
        colour = COLOURS["soft"] if tick == 1.0 else COLOURS["line"]
        parts.append(f'<path d="M{place(tick):.1f} {top}V{floor}" stroke="{colour}"/>')
        parts.append(_text(place(tick), floor + 16, f"{tick:.0%}", anchor="middle"))
    for k, (line, row) in enumerate(zip(lines, shares, strict=True)):
        y = top + _ROW * (k + 0.5)
        title = f"{line.rank}  {_short(line.row.title)}"
        parts.append(_text(_LEFT - 12, y + 4, title, anchor="end", colour=COLOURS["ink"], size=13))
        known = [place(share) for share in row if np.isfinite(share) and share > 0]
        if known:
            parts.append(f'<path d="M{min(known):.1f} {y:g}H{max(known):.1f}" stroke="{COLOURS["line"]}"/>')
        for speed, share in zip(speeds, row, strict=True):
            if np.isfinite(share) and share > 0:
                parts.append(f'<circle cx="{place(share):.1f}" cy="{y:g}" r="5" fill="{_colour(speed)}"/>')
    words = "share of the error without compensation that is left (logarithmic)"
    parts.append(_text((_LEFT + _WIDTH) / 2, floor + 34, words, anchor="middle"))
    return _svg(_WIDTH, floor + 42, parts, "Share of the path error that every ranked agent leaves at each speed")


def _legend(speeds: Sequence[float]) -> str:
    parts = []
    for k, speed in enumerate(speeds):
        x = _LEFT + 8 + 110 * k
        parts.append(f'<circle cx="{x}" cy="14" r="5" fill="{_colour(speed)}"/>{_text(x + 10, 18, f"{speed:g} mm/s")}')
    return "".join(parts)


def _colour(speed: float) -> str:
    return _SPEEDS.get(speed, COLOURS["ink"])


def _svg(width: float, height: float, parts: Sequence[str], label: str) -> str:
    return (
        f'<svg viewBox="0 0 {width:g} {height:g}" width="{width:g}" height="{height:g}" role="img" '
        f'aria-label="{escape(label)}">{"".join(parts)}</svg>'
    )


def _text(x: float, y: float, words: str, *, anchor: str = "start", colour: str = "", size: int = 12) -> str:
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" font-size="{size}" '
        f'fill="{colour or COLOURS["soft"]}">{escape(words)}</text>'
    )


def _short(title: str) -> str:
    return title if len(title) <= 40 else title[:39] + "…"
