"""Least squares with bounds on all coefficients, for many small problems at once."""

import numpy as np

from ffgym.core.types import Array

_SWEEPS = 40
"""Passes over all coefficients: enough for what is left, which is all that is asked; columns are next to orthogonal or
exchangeable."""

_RIDGE = 1e-3
"""Weight of the expected coefficients, in the energy of a column, which decides between columns that say the same."""


def bounded_fit(gram: Array, moment: Array, low: Array, high: Array, expected: Array) -> Array:
    """Coefficients (B, K) that minimise the squares left by K columns, by coordinate descent.

    Args:
        gram: products of the columns, shape (B, K, K).
        moment: products of columns and target, shape (B, K).
        low: smallest coefficients, shape (K,).
        high: largest coefficients, shape (K,).
        expected: those that are taken where columns do not tell, shape (K,).
    """
    size = np.sqrt(np.maximum(np.einsum("bkk->bk", gram), 1e-300))
    scaled = gram / (size[:, :, None] * size[:, None, :])
    lowest, highest, wanted = low * size, high * size, expected * size
    found = np.clip(wanted, lowest, highest)
    target = moment / size
    slope = np.einsum("bkl,bl->bk", scaled, found) - target
    for _ in range(_SWEEPS):
        for k in range(gram.shape[1]):
            step = (slope[:, k] + _RIDGE * (found[:, k] - wanted[:, k])) / (1.0 + _RIDGE)
            new = np.clip(found[:, k] - step, lowest[:, k], highest[:, k])
            slope += scaled[:, :, k] * (new - found[:, k])[:, None]
            found[:, k] = new
    return np.asarray(found / size)
