"""Values that readers seldom see: numbers at and beyond every edge, texts that are names, paths, controls or very long.

Two of them cannot be written by any library and stand as markers in a tree until its text is made: lists in lists
without end, and a number of more digits than Python turns into text.
"""

import re
from typing import Any

import numpy as np

_NESTED, _DIGITS = "@nested:", "@digits:"
_MARKER = re.compile(f'"({_NESTED}|{_DIGITS})([0-9]+)"')

NUMBERS: tuple[Any, ...] = (
    *(0, -1, 1, 2, 7, 0.5, -0.0, 1e-302, 5e-324, 1e-9, 1e9, 1e154, 1.7e308, -1e300),
    *(2**31, 2**53 + 1, 2**63, -(2**63) - 1, 10**400, float("nan"), float("inf"), float("-inf")),
)
"""Numbers of a kind that is rare, or that no float64 or int64 holds."""

TEXTS = (
    *("", " ", "0", "1e3", "nan", "true", "null", "x" * 300, "a" * 100_000, "\0", "a\nb", "\ud800", "é", "\x1b[31m"),
    *("..", ".", "../../x", "/dev/zero", "/", "file.npz", "CON", "rad", "mm", "ns", "deg", "$(x)", "{0}", "%s"),
)
"""Texts that are empty, long, not printable, look like numbers, or lead to other files."""

FACTORS = (-1.0, 1e-3, 1e3, 1e-9, 1e9, 180 / np.pi, np.pi / 180, 1 + 1e-12)
"""Factors of a slip of the unit, from ns to s and from mm to m and back."""


def nested(depth: int) -> str:
    """Mark the place of a list in a list in a list ..., `depth` of them."""
    return f"{_NESTED}{depth}"


def digits(count: int) -> str:
    """Mark the place of a whole number of `count` digits."""
    return f"{_DIGITS}{count}"


def write_markers(text: str) -> str:
    """Put what markers stand for into JSON or TOML."""

    def write(found: re.Match[str]) -> str:
        count = int(found[2])
        return "[" * count + "]" * count if found[1] == _NESTED else "9" * count

    return _MARKER.sub(write, text)


def odd_value(rng: np.random.Generator) -> Any:
    """Draw a value of any kind, mostly small ones."""
    kind = rng.integers(20)
    if kind < 9:
        return NUMBERS[rng.integers(len(NUMBERS))]
    if kind < 14:
        return TEXTS[rng.integers(len(TEXTS))]
    if kind == 14:
        return nested(int(rng.choice([3, 60, 900, 100_000])))
    if kind == 15:
        return digits(int(rng.choice([20, 400, 5000])))
    others: tuple[Any, ...] = (None, True, [], {})
    return others[kind - 16]
