"""Pictures as SVG inside a page, drawn from numbers alone; titles of agents are escaped."""

from collections.abc import Sequence
from html import escape

import numpy as np
from numpy.typing import ArrayLike

COLOURS = {"zero": "#E69F00", "own": "#0072B2", "ink": "#1c2430", "soft": "#5a6472", "line": "#d9dee5"}
"""Of lines and words; shades of Okabe and Ito on the greys of the pages."""


def number(value: float) -> str:
    """A number of a picture, with three digits behind the point at most."""
    digits = f"{value:.3f}".rstrip("0").rstrip(".")
    return "0" if digits == "-0" else digits


def polyline(points: ArrayLike, colour: str, *, width: float, dash: str = "") -> str:
    """Line through points, shape (T, 2), y upwards, whose width does not grow with the picture."""
    places = " ".join(f"{number(x)},{number(-y)}" for x, y in np.asarray(points, dtype=float))
    dashes = f' stroke-dasharray="{dash}"' if dash else ""
    return (
        f'<polyline points="{places}" fill="none" stroke="{colour}" stroke-width="{width:g}"{dashes} '
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
        text(left - 6, 16, f"{high:.3g}", anchor="end"),
        text(left - 6, floor, f"{low:.3g}", anchor="end"),
        text(left, floor + 15, f"{steps[0]:,.0f}"),
        text(width - 14, floor + 15, f"{steps[-1]:,.0f}", anchor="end"),
        text((left + width) / 2, floor + 29, "control steps of training", anchor="middle"),
    ]
    label = f"Learning curve: mean reward per step from {rewards[0]:.3g} to {rewards[-1]:.3g}"
    return svg(width, height, parts, label)


def svg(width: float, height: float, parts: Sequence[str], label: str) -> str:
    """A picture of parts, with what it is for those who do not see it."""
    return (
        f'<svg viewBox="0 0 {width:g} {height:g}" width="{width:g}" height="{height:g}" role="img" '
        f'aria-label="{escape(label)}">{"".join(parts)}</svg>'
    )


def text(x: float, y: float, words: str, *, anchor: str = "start", colour: str = "", size: int = 12) -> str:
    """Words in a picture."""
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" font-size="{size}" '
        f'fill="{colour or COLOURS["soft"]}">{escape(words)}</text>'
    )
