"""What changes slowly along a motion: evaluated at a few samples, and on cubics between them."""

import numpy as np
from scipy.sparse import csr_array

from ffgym.core.types import Array, IntArray

_POINTS = 4
"""Evaluations about a sample that it is interpolated from: those of a cubic."""


def places_of(n: int, every: int) -> IntArray:
    """Samples, of so many, at which terms are evaluated; all where they are too few to interpolate."""
    places: IntArray = np.unique(np.append(np.arange(0, n, every), n - 1))
    return places if len(places) >= _POINTS else np.arange(n)


def cubics(places: IntArray) -> csr_array:
    """Weights of values at P `places`, sample numbers, in all T samples up to the last of them, shape (T, P).

    Each is on the cubic through the four places around it (Lagrange): as near as a spline of values that vary this
    slowly, and thirty times as fast.
    """
    samples = np.arange(places[-1] + 1)
    first = np.clip(np.searchsorted(places, samples, side="right") - 2, 0, len(places) - _POINTS)
    near = first[:, None] + np.arange(_POINTS)
    x = places[near]
    weights = np.ones(near.shape)
    for a in range(_POINTS):
        for b in set(range(_POINTS)) - {a}:
            weights[:, a] *= (samples - x[:, b]) / (x[:, a] - x[:, b])
    ends = np.arange(0, near.size + 1, _POINTS)
    return csr_array((weights.ravel(), near.ravel(), ends), shape=(len(samples), len(places)))


def along(places: IntArray, values: Array) -> Array:
    """Values (P, ...) at `places` in all T samples up to the last of them, (T, ...)."""
    n = int(places[-1]) + 1
    if len(places) == n:
        return values
    found: Array = cubics(places) @ values.reshape(len(places), -1)
    return found.reshape(n, *values.shape[1:])
