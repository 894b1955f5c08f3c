"""Errors drawn larger than they are: across the path only, by a round factor."""

import numpy as np

from ffgym.core.types import Array


def magnified(nearest: Array, error: Array, factor: float) -> Array:
    """Path of a tool with its error enlarged, as it is drawn.

    Args:
        nearest: nearest points of the path that it should follow, shape (T, D).
        error: tool - nearest point, shape (T, D); being late on the right path is none.
        factor: of the error.
    """
    drawn: Array = nearest + factor * error
    return drawn


def magnification(room: float, largest: float, most: float = np.inf) -> float:
    """Round factor, 1 to `most`, with which an error of `largest` takes at most `room`, in the same unit.

    It is 1 where there is no error and no `most`.
    """
    if largest == 0:
        return most if np.isfinite(most) else 1.0
    return min(max(1.0, round_down(room / largest)), most)


def round_down(value: float) -> float:
    """Largest of ..., 0.1, 0.2, 0.5, 1, 2, 5, 10, ... that is not above `value`, which is > 0."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(max(step for step in (1.0, 2.0, 5.0) if step <= value / power * (1 + 1e-9)) * power)
