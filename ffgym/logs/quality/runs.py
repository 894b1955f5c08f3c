"""Stretches of a column: of one value, of rows that follow one another; and its smallest step."""

import numpy as np

from ffgym.core.types import Array, BoolArray


def stretches(inside: BoolArray, shortest: int = 1) -> list[slice]:
    """Stretches of rows that are `inside` (T,), at least `shortest` long, in order."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], inside.astype(np.int8), [0]])))
    pairs = edges.reshape(-1, 2)
    return [slice(int(start), int(stop)) for start, stop in pairs if stop - start >= shortest]


def constant_stretches(x: Array, shortest: int) -> list[slice]:
    """Stretches of one value in `x` (T,), at least `shortest` rows long."""
    return [slice(rows.start, rows.stop + 1) for rows in stretches(np.diff(x) == 0, shortest - 1)]


ROUNDING = 1e-6
"""Share of the range of a column below which a difference is rounding: of a speed from differences of large angles it
is 1e-9, of the finest encoder in use a step is 1e-5."""


def smallest_step(x: Array) -> float:
    """Smallest difference between neighbours in `x` (T,) that is more than rounding; 0 if there is none."""
    steps = np.abs(np.diff(x))
    steps = steps[steps > ROUNDING * np.ptp(x)]
    return float(steps.min()) if steps.size else 0.0


def grid_step(x: Array) -> float:
    """Step of the grid on which all values of `x` (T,) lie; 0 if they lie on none.

    Ten different values must fit to a hundredth of a step: three always do.
    """
    values = np.unique(x)
    step = smallest_step(values)
    if step == 0.0 or len(values) < 10:
        return 0.0
    offsets = (values - values[0]) / step
    off = np.abs(offsets - np.round(offsets))
    return step if np.all(off < 0.01 + ROUNDING * offsets.max()) else 0.0
