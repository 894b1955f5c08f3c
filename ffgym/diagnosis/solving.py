r"""Least squares with priors and bounds, from sums over blocks: one fit, and the held-out gains of many candidates.

With calibration columns n and those of one candidate c, a fold's training sums give

.. math::
    V = A^{-1} G_{nc}, \quad x = S^{-1} (m_c - V^T m_n), \quad S = G_{cc} - V^T G_{nc} + P_c, \quad A = G_{nn} + P_n

and what the candidate removes from the blocks that were left out is

.. math:: D = 2 x^T w - x^T W x, \quad w = m'_c - V^T m'_n, \quad W = [-V; 1]^T G' [-V; 1]

of their residual moments m' after the calibration alone. Only sums enter, for the log and for noise alike.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy

from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.diagnosis.normal_equations import NormalEquations
from ffgym.diagnosis.resampling import Fold
from ffgym.diagnosis.settings import settings


@dataclass(frozen=True, kw_only=True, eq=False)
class Priors:
    """Precision and bounds of all columns, in the units in which they are scaled, shape (P,) each."""

    precision: Array
    low: Array
    high: Array


_PATIENCE = 6
"""Rounds without fewer parameters at fault in which all of them are exchanged at once, which is fast but may go in
circles; then they are exchanged one by one until fewer are."""

_ROUNDS = 3
"""Rounds per parameter at most; a fifth of one is usual. Only rounding can make them go on."""

_ONE_BY_ONE = 20
"""Steps per parameter of the slower method at most; it takes about one."""


def solve_bounded(gram: Array, moment: Array, precision: Array, low: Array, high: Array) -> Array:
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
        # minimum over the free numbers, with the others held at their bounds
        held = ~free
        target = moment[free] - (full[np.ix_(free, held)] @ x[held] if held.any() else 0.0)
        if free.any():
            x[free] = scipy.linalg.cho_solve(scipy.linalg.cho_factor(full[np.ix_(free, free)]), target)
        # numbers beyond a bound, and held ones that the slope pulls inside
        slope = moment - full @ x
        out = free & ((x < low) | (x > high))
        back = held & (low < high) & (((x <= low) & (slope > 0)) | ((x >= high) & (slope < 0)))
        at_fault = np.flatnonzero(out | back)
        if not len(at_fault):
            return x
        # exchange all of them; only the last one if that has stopped helping, so that it ends
        fewest, patience = (len(at_fault), _PATIENCE) if len(at_fault) < fewest else (fewest, patience - 1)
        exchanged = at_fault if patience >= 0 else at_fault[-1:]
        x[exchanged] = np.clip(x[exchanged], low[exchanged], high[exchanged])
        free[exchanged] = ~free[exchanged]
    # the same minimum, by a method that always ends
    root = scipy.linalg.cholesky(full)
    target = scipy.linalg.solve_triangular(root, moment, trans="T")
    x = scipy.optimize.lsq_linear(root, target, (low, high), method="bvls", max_iter=_ONE_BY_ONE * len(moment)).x
    return np.asarray(x)


def compute_block_rss(equations: NormalEquations, folds: Sequence[Fold], columns: IntArray, priors: Priors) -> Array:
    """Energy left in each block by a fit of `columns` to the blocks that are not left out with it, shape (B,)."""
    left = np.zeros(len(equations.blocks))
    for fold in folds:
        x = solve(equations, columns, priors, fold.train)
        for b in np.flatnonzero(fold.test):
            inner = equations.gram[b][np.ix_(columns, columns)]
            left[b] = equations.energy[b, 0] - 2 * x @ equations.moment[b, columns, 0] + x @ inner @ x
    return left


def solve(equations: NormalEquations, columns: IntArray, priors: Priors, blocks: BoolArray | None = None) -> Array:
    """Parameters of `columns` fitted to the log in some blocks, or to all, shape (len(columns),)."""
    chosen = slice(None) if blocks is None else blocks
    gram, pull = equations.gram[chosen].sum(axis=0), equations.moment[chosen].sum(axis=0)[:, 0]
    known = (of[columns] for of in (priors.precision, priors.low, priors.high))
    return solve_bounded(gram[np.ix_(columns, columns)], pull[columns], *known)


_ALIKE = 1e-12
"""Share of its energy by which columns of a candidate must differ to be told apart; chosen: ten thousand roundings. Of
sizes that a log without noise shows as one, each then takes a part."""

_NEAR = 1e-6
"""Way to its bound within which a calibration error stands there already [standard deviations]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Candidate:
    """Columns that are adopted together."""

    columns: IntArray
    """Their places among all columns."""
    one_sided: bool
    """True if its single parameter cannot be negative."""


def screen(
    equations: NormalEquations,
    folds: Sequence[Fold],
    nuisances: IntArray,
    candidates: Sequence[Candidate],
    priors: Priors,
) -> tuple[Array, Array]:
    """Held-out gains of C candidates beside the calibration columns, for K residuals.

    Returns:
        Energy that each removes from what was left out, (C, K), and what the calibration alone leaves there, (K,), in
        units of the noise's energy per row.
    """
    n_residuals = equations.moment.shape[2]
    gain, left = np.zeros((len(candidates), n_residuals)), np.zeros(n_residuals)
    log, noise = slice(0, 1), slice(1, n_residuals)
    alike = _alike(candidates)
    for train, test in _sums(equations, folds, nuisances, alike):
        known, of_log = priors.precision[nuisances], _as_prior(train, nuisances, priors)
        apart = ((log, of_log), (noise, known)) if noise.start < noise.stop else ((log, of_log),)
        for residuals, precision in ((slice(None), known),) if np.array_equal(of_log, known) else apart:
            less, gains = _gains(train.of(residuals), test.of(residuals), nuisances, precision, alike)
            left[residuals] += less
            for group, more in zip(alike, gains, strict=True):
                gain[group.places, residuals] += more
    return gain, left


@dataclass(frozen=True, kw_only=True, eq=False)
class _Alike:
    """Candidates with equally many columns."""

    places: IntArray
    """Among all candidates, shape (C,)."""
    columns: IntArray
    """Shape (C, S)."""
    one_sided: BoolArray
    """Shape (C,)."""


def _alike(candidates: Sequence[Candidate]) -> list[_Alike]:
    """Group candidates by their number of columns."""
    sizes = np.array([len(candidate.columns) for candidate in candidates])
    found = []
    for size in np.unique(sizes):
        places = np.flatnonzero(sizes == size)
        chosen = [candidates[int(i)] for i in places]
        columns = np.stack([candidate.columns for candidate in chosen])
        one_sided = np.array([candidate.one_sided for candidate in chosen])
        found.append(_Alike(places=places, columns=columns, one_sided=one_sided))
    return found


@dataclass(frozen=True, kw_only=True, eq=False)
class _Sums:
    """Sums over some blocks: the parts of the Gram matrix G that matter, and the moments of K residuals."""

    nuisances: Array
    """Rows of G of the F calibration columns, shape (F, P)."""
    within: tuple[Array, ...]
    """G among the columns of each candidate, shape (C, S, S), by size of candidates."""
    moment: Array
    """Shape (P, K)."""
    energy: Array
    """Shape (K,)."""

    def of(self, residuals: slice) -> "_Sums":
        """Select the sums of some residuals."""
        return replace(self, moment=self.moment[:, residuals], energy=self.energy[residuals])


def _sums(
    equations: NormalEquations, folds: Sequence[Fold], nuisances: IntArray, alike: Sequence[_Alike]
) -> Iterator[tuple[_Sums, _Sums]]:
    """Sum the blocks that each fold fits to and judges by; blocks that always go together are summed once."""
    member = np.array([rows for fold in folds for rows in (fold.train, fold.test)])
    kinds, of_block = np.unique(member, axis=1, return_inverse=True)
    of_block = of_block.ravel()

    def by_kind(values: Array) -> Array:
        return np.stack([values[of_block == k].sum(axis=0) for k in range(kinds.shape[1])])

    beside = by_kind(equations.gram[:, nuisances])
    within = [by_kind(equations.gram[:, one.columns[:, :, None], one.columns[:, None, :]]) for one in alike]
    moment, energy = by_kind(equations.moment), by_kind(equations.energy)

    def add_up(chosen: BoolArray) -> _Sums:
        return _Sums(
            nuisances=beside[chosen].sum(axis=0),
            within=tuple(blocks[chosen].sum(axis=0) for blocks in within),
            moment=moment[chosen].sum(axis=0),
            energy=energy[chosen].sum(axis=0),
        )

    for train, test in zip(kinds[::2], kinds[1::2], strict=True):
        yield add_up(train), add_up(test)


def _gains(
    train: _Sums, test: _Sums, columns: IntArray, precision: Array, alike: Sequence[_Alike]
) -> tuple[Array, list[Array]]:
    """Energy that calibration leaves outside of a fold, (K,), and that candidates remove there, (C, K) by size.

    Symbols are those of the module.
    """
    factor = scipy.linalg.cho_factor(train.nuisances[:, columns] + np.diag(precision))
    x = scipy.linalg.cho_solve(factor, train.moment[columns])
    v = scipy.linalg.cho_solve(factor, train.nuisances)
    rest = test.moment - test.nuisances.T @ x
    left = test.energy - np.sum(x * (test.moment + rest)[columns], axis=0)
    # of all columns, beside the calibration: G'_nn V, residual moments m_c - V^T m_n, and w
    through, pull = test.nuisances[:, columns] @ v, train.moment - v.T @ train.moment[columns]
    held_out, found = rest - v.T @ rest[columns], []
    for group, own, own_test in zip(alike, train.within, test.within, strict=True):
        at = group.columns
        v_c = v[:, at].transpose(1, 2, 0)
        inner = own - v_c @ train.nuisances[:, at].transpose(1, 0, 2)
        cross = v_c @ test.nuisances[:, at].transpose(1, 0, 2)
        size = own_test - cross - cross.transpose(0, 2, 1) + v_c @ through[:, at].transpose(1, 0, 2)
        ridge = settings().screening.width ** -2 + _ALIKE * np.diagonal(own, axis1=1, axis2=2)
        x_c = np.linalg.solve(inner + ridge[:, :, None] * np.eye(at.shape[1]), pull[at])
        x_c[group.one_sided] = np.maximum(x_c[group.one_sided], 0.0)
        found.append(np.sum(x_c * (2 * held_out[at] - size @ x_c), axis=1))
    return left, found


def _as_prior(fold: _Sums, columns: IntArray, priors: Priors) -> Array:
    """Precisions under which calibration errors that would leave their bounds come to lie at them, shape (F,).

    They stay as soft as that when a candidate joins, and come back from their bounds if it takes over.
    """
    train, pull = fold.nuisances[:, columns], fold.moment[columns, 0]
    precision = priors.precision[columns]
    x = solve_bounded(train, pull, precision, priors.low[columns], priors.high[columns])
    slope = pull - train @ x - precision * x
    outward = ((x >= priors.high[columns]) & (slope > 0)) | ((x <= priors.low[columns]) & (slope < 0))
    return precision + np.where(outward, np.abs(slope) / np.maximum(np.abs(x), _NEAR), 0.0)
