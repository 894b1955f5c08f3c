"""Magnification of errors in pictures: across the path only, by a round factor."""

import numpy as np

from ffgym.core.types import Array


def magnify(nearest: Array, error: Array, factor: float) -> Array:
    """Compute the path of a tool with its error enlarged, for a picture.

    Args:
        nearest: nearest points of the path that it should follow, shape (T, D).
        error: tool - nearest point, shape (T, D); lag along the path does not count.
        factor: magnification of the error.
    """
    drawn: Array = nearest + factor * error
    return drawn


def magnification(room: float, largest: float, most: float = np.inf) -> float:
    """Choose a round factor, 1 to `most`, so that an error of `largest` takes at most `room`, in the same unit.

    It is 1 without an error and without `most`.
    """
    if largest == 0:
        return most if np.isfinite(most) else 1.0
    return min(max(1.0, round_down(room / largest)), most)


def round_down(value: float) -> float:
    """Return the largest of ..., 0.1, 0.2, 0.5, 1, 2, 5, 10, ... that is not above `value`, which is > 0."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(max(step for step in (1.0, 2.0, 5.0) if step <= value / power * (1 + 1e-9)) * power)
