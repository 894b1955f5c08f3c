r"""Linear recursions along samples as banded triangular systems, and cubics through a few evaluations.

A loop over samples takes most of its time between them. LAPACK goes through the same additions and multiplications in
the same order, without.
"""

import numpy as np
import scipy

from ffgym.core.types import Array, IntArray

_AT_ONCE = 256
"""Samples of springs that are solved for at once; chosen: their matrix stays in a cache of the processor."""


def first_order(keep: Array, gain: Array, start: Array) -> Array:
    """Values z of z[k + 1] = keep[k] z[k] + gain[k], shape (T, ...), from z[0] = `start` on."""
    right = np.concatenate([start[None], gain])
    shape, n = right.shape, len(right)
    right = right.reshape(n, -1)
    below = np.zeros((right.shape[1], n, 2))
    below[:, :-1, 1] = -keep.reshape(n - 1, right.shape[1]).T
    found = np.empty_like(right)
    for i, band in enumerate(below):
        found[:, i] = _solve_banded(band, right[:, i : i + 1])[:, 0]
    return found.reshape(shape)


def swing(by_load: Array, by_place: Array, by_rate: Array, load: Array, start: Array, dt: float) -> Array:
    r"""Swing of E joints by Newmark's method of constant average acceleration, for V loads at once.

    .. math:: a_k = A_k p_k - B_k \hat x_k - C_k \hat v_k, \quad
        \hat v_{k+1} = \hat v_k + h a_k, \quad \hat x_{k+1} = \hat x_k + h \hat v_{k+1}

    with the place and the rate that the step before leads to, :math:`\hat x = x - h^2 a / 4` and
    :math:`\hat v = v - h a / 2`.

    Args:
        by_load: A, shape (T, E, E).
        by_place: B, likewise.
        by_rate: C, likewise.
        load: p, shape (T, E, V).
        start: x at the first sample, shape (E, V), at rest there.
        dt: h [s].

    Returns:
        Place, rate and acceleration, shape (3, T, E, V).
    """
    (n, e, v), joint = load.shape, np.arange(load.shape[1])
    pull = np.matmul(by_load, load)
    found = np.empty((3, n, e, v))
    # unknowns of a sample in this order: rate, place, acceleration; a row per unknown, its own equation first
    band = np.zeros((min(n, _AT_ONCE), 3 * e, 3 * e + 1))
    band[:, : 2 * e, 3 * e] = -1.0
    band[:, :e, e] = band[:, 2 * e :, e] = -dt
    # a stretch of samples at a time, so that the banded matrix stays small; each begins where the one before ended
    by, of = joint, joint[:, None]
    rate, place = np.zeros((e, v)), start
    for first in range(0, n, _AT_ONCE):
        rows = slice(first, min(first + _AT_ONCE, n))
        count = rows.stop - rows.start
        band[:count, by, 2 * e + of - by] = by_rate[rows]
        band[:count, e + by, e + of - by] = by_place[rows]
        right = np.zeros((v, count, 3, e))
        right[:, 0, 0], right[:, 0, 1] = rate.T, place.T
        right[:, :, 2] = pull[rows].transpose(2, 0, 1)
        solved = _solve_banded(band[:count].reshape(-1, 3 * e + 1), right.reshape(v, -1).T).T.reshape(right.shape)
        found[:, rows] = solved[:, :, [1, 0, 2]].transpose(2, 1, 3, 0)
        place, rate = found[0, rows.stop - 1], found[1, rows.stop - 1] + dt * found[2, rows.stop - 1]
    # correct the predicted place and rate by the acceleration of the sample
    found[0] += dt**2 / 4 * found[2]
    found[1] += dt / 2 * found[2]
    return found


def _solve_banded(band: Array, right: Array) -> Array:
    """Solve a lower triangular system with a diagonal of ones for (S, V); row j of `band` has its column j."""
    found, _ = scipy.linalg.lapack.dtbtrs(band.T, right, uplo="L", diag="U")
    solved: Array = found
    return solved


_POINTS = 4
"""Evaluations about a sample that it is interpolated from: those of a cubic."""


def places_of(n: int, every: int) -> IntArray:
    """Samples, of so many, at which terms are evaluated; all where they are too few to interpolate."""
    places: IntArray = np.unique(np.append(np.arange(0, n, every), n - 1))
    return places if len(places) >= _POINTS else np.arange(n)


def cubics(places: IntArray) -> "scipy.sparse.csr_array":
    """Weights of values at P `places`, sample numbers, in all T samples up to the last of them, shape (T, P).

    Each is on the cubic through the four places around it (Lagrange): as near as a spline of values that vary this
    slowly, and thirty times as fast.
    """
    samples = np.arange(places[-1] + 1)
    if len(places) == len(samples):
        return scipy.sparse.eye_array(len(places), format="csr")
    first = np.clip(np.searchsorted(places, samples, side="right") - 2, 0, len(places) - _POINTS)
    near = first[:, None] + np.arange(_POINTS)
    x = places[near]
    weights = np.ones(near.shape)
    for a in range(_POINTS):
        for b in set(range(_POINTS)) - {a}:
            weights[:, a] *= (samples - x[:, b]) / (x[:, a] - x[:, b])
    ends = np.arange(0, near.size + 1, _POINTS)
    return scipy.sparse.csr_array((weights.ravel(), near.ravel(), ends), shape=(len(samples), len(places)))


def along(places: IntArray, values: Array) -> Array:
    """Values (P, ...) at `places` in all T samples up to the last of them, (T, ...)."""
    n = int(places[-1]) + 1
    if len(places) == n:
        return values
    found: Array = cubics(places) @ values.reshape(len(places), -1)
    return found.reshape(n, *values.shape[1:])
