"""Least squares with priors and bounds, from sums."""

import numpy as np
from scipy.linalg import cho_factor, cho_solve, cholesky, solve_triangular
from scipy.optimize import lsq_linear

from ffgym.types import Array

_ROUNDS = 12
"""Rounds in which all parameters that leave their bounds are held there at once, which is fast but may go in circles;
then they are held one by one."""

_ONE_BY_ONE = 20
"""Steps per parameter of the slower method at most; it takes about one."""


def bounded(gram: Array, moment: Array, precision: Array, low: Array, high: Array) -> Array:
    r"""Minimum of :math:`x^T G x - 2 x^T m + x^T P x` within bounds, by an active set; shape (P,).

    Args:
        gram: G, shape (P, P).
        moment: m, shape (P,).
        precision: diagonal of the prior's P, shape (P,), > 0.
        low: shape (P,).
        high: shape (P,).
    """
    x, free = np.zeros(len(moment)), np.ones(len(moment), dtype=np.bool_)
    full = gram + np.diag(precision)
    for _ in range(_ROUNDS):
        held = ~free
        target = moment[free] - (full[np.ix_(free, held)] @ x[held] if held.any() else 0.0)
        x[free] = cho_solve(cho_factor(full[np.ix_(free, free)]), target) if free.any() else x[free]
        out = free & ((x < low) | (x > high))
        x = np.clip(x, low, high)
        slope = moment - full @ x
        back = ~free & (((x <= low) & (slope > 0)) | ((x >= high) & (slope < 0)))
        if not out.any() and not back.any():
            return x
        free = (free & ~out) | back
    return _one_by_one(full, moment, low, high)


def _one_by_one(full: Array, moment: Array, low: Array, high: Array) -> Array:
    """The same minimum, by a method that always ends."""
    root = cholesky(full)
    target = solve_triangular(root, moment, trans="T")
    x: Array = lsq_linear(root, target, (low, high), method="bvls", max_iter=_ONE_BY_ONE * len(moment)).x
    return x
