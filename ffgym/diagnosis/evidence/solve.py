"""Least squares with priors and bounds, from sums."""

import numpy as np
from scipy.linalg import cho_factor, cho_solve, cholesky, solve_triangular
from scipy.optimize import lsq_linear

from ffgym.core.types import Array

_PATIENCE = 6
"""Rounds without fewer parameters at fault in which all of them are exchanged at once, which is fast but may go in
circles; then they are exchanged one by one until fewer are."""

_ROUNDS = 3
"""Rounds per parameter at most; a fifth of one is usual. Only rounding can make them go on."""

_ONE_BY_ONE = 20
"""Steps per parameter of the slower method at most; it takes about one."""


def bounded(gram: Array, moment: Array, precision: Array, low: Array, high: Array) -> Array:
    r"""Minimum of :math:`x^T G x - 2 x^T m + x^T P x` within bounds, by block principal pivoting; shape (P,).

    Args:
        gram: G, shape (P, P).
        moment: m, shape (P,).
        precision: diagonal of the prior's P, shape (P,), > 0.
        low: shape (P,).
        high: shape (P,).

    Reference:
        Judice, Pires (1994), Computers & Operations Research 21(5), with the rule of Murty against circles.
    """
    x, free = np.zeros(len(moment)), np.ones(len(moment), dtype=np.bool_)
    full = gram + np.diag(precision)
    fewest, patience = len(moment) + 1, _PATIENCE
    for _ in range(_ROUNDS * (len(moment) + 1)):
        held = ~free
        target = moment[free] - (full[np.ix_(free, held)] @ x[held] if held.any() else 0.0)
        x[free] = cho_solve(cho_factor(full[np.ix_(free, free)]), target) if free.any() else x[free]
        slope = moment - full @ x
        out = free & ((x < low) | (x > high))
        back = held & (low < high) & (((x <= low) & (slope > 0)) | ((x >= high) & (slope < 0)))
        at_fault = np.flatnonzero(out | back)
        if not len(at_fault):
            return x
        fewest, patience = (len(at_fault), _PATIENCE) if len(at_fault) < fewest else (fewest, patience - 1)
        exchanged = at_fault if patience >= 0 else at_fault[-1:]
        x[exchanged] = np.clip(x[exchanged], low[exchanged], high[exchanged])
        free[exchanged] = ~free[exchanged]
    return _one_by_one(full, moment, low, high)


def _one_by_one(full: Array, moment: Array, low: Array, high: Array) -> Array:
    """The same minimum, by a method that always ends."""
    root = cholesky(full)
    target = solve_triangular(root, moment, trans="T")
    x: Array = lsq_linear(root, target, (low, high), method="bvls", max_iter=_ONE_BY_ONE * len(moment)).x
    return x
