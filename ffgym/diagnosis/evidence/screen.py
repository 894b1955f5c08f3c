r"""Held-out gains of many candidates at once.

With calibration columns n and those of one candidate c, a fold's training sums give

.. math::
    V = A^{-1} G_{nc}, \quad x = S^{-1} (m_c - V^T m_n), \quad S = G_{cc} - V^T G_{nc} + P_c, \quad A = G_{nn} + P_n

and what the candidate removes from the blocks that were left out is

.. math:: D = 2 x^T w - x^T W x, \quad w = m'_c - V^T m'_n, \quad W = [-V; 1]^T G' [-V; 1]

of their residual moments m' after the calibration alone. Only sums enter, for the log and for noise alike.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from ffgym.diagnosis.evidence.folds import Fold
from ffgym.diagnosis.evidence.solve import bounded
from ffgym.diagnosis.evidence.stack import Evidence
from ffgym.types import Array, BoolArray, IntArray

_WIDE = 10.0
"""Standard deviation of a candidate's parameter in its steps: as good as free, but not without end."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Priors:
    """Of all columns, in the units in which they are scaled, shape (P,) each."""

    precision: Array
    low: Array
    high: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Candidate:
    """Columns that are adopted together."""

    columns: IntArray
    """Their places among all columns."""
    one_sided: bool
    """Whether its single parameter cannot be negative."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Screened:
    """Gains of C candidates with K residuals, in units of the noise's energy per row."""

    gain: Array
    """Energy removed from what was left out, shape (C, K)."""
    left: Array
    """Energy that the calibration alone leaves in what was left out, shape (K,)."""


def screen(
    evidence: Evidence, folds: Sequence[Fold], calibration: IntArray, candidates: Sequence[Candidate], priors: Priors
) -> Screened:
    """Held-out gain of every candidate beside the calibration columns."""
    n_residuals = evidence.moment.shape[2]
    gain, left = np.zeros((len(candidates), n_residuals)), np.zeros(n_residuals)
    log, noise = slice(0, 1), slice(1, n_residuals)
    for fold in folds:
        precision = _as_prior(evidence, fold, calibration, priors)
        for residuals, fitted in (
            (log, _fit(evidence, fold, calibration, precision, log)),
            (noise, _fit(evidence, fold, calibration, priors.precision[calibration], noise)),
        ):
            left[residuals] += fitted.left
            for i, candidate in enumerate(candidates):
                gain[i, residuals] += fitted.gain_of(candidate)
    return Screened(gain=gain, left=left)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Fitted:
    """Calibration fitted to a fold's training blocks, and what it leaves there and in those left out."""

    train: Array
    test: Array
    train_pull: Array
    """Moments of the residual as it is, shape (P, K)."""
    test_moment: Array
    """Moments of what the calibration leaves, shape (P, K)."""
    free: IntArray
    inverse_cross: Array
    """V of all columns, shape (F, P)."""
    left: Array

    def gain_of(self, candidate: Candidate) -> Array:
        """Energy that a candidate removes from the blocks left out, shape (K,)."""
        c, f = candidate.columns, self.free
        v = self.inverse_cross[:, c]
        inner = self.train[np.ix_(c, c)] - v.T @ self.train[np.ix_(f, c)] + np.diag(np.full(len(c), _WIDE**-2))
        pull = self.train_pull[c] - v.T @ self.train_pull[f]
        x = np.linalg.solve(inner, pull)
        if candidate.one_sided:
            x = np.maximum(x, 0.0)
        w = self.test_moment[c] - v.T @ self.test_moment[f]
        cross = v.T @ self.test[np.ix_(f, c)]
        size = self.test[np.ix_(c, c)] - cross - cross.T + v.T @ self.test[np.ix_(f, f)] @ v
        gained: Array = 2 * np.einsum("ck,ck->k", x, w) - np.einsum("ck,ck->k", x, size @ x)
        return gained


def _fit(evidence: Evidence, fold: Fold, columns: IntArray, precision: Array, residuals: slice) -> _Fitted:
    train, test = evidence.gram[fold.train].sum(axis=0), evidence.gram[fold.test].sum(axis=0)
    pull = evidence.moment[fold.train][:, :, residuals].sum(axis=0)
    held_out = evidence.moment[fold.test][:, :, residuals].sum(axis=0)
    factor = cho_factor(train[np.ix_(columns, columns)] + np.diag(precision))
    x = np.zeros_like(pull)
    x[columns] = cho_solve(factor, pull[columns])
    energy = evidence.energy[fold.test][:, residuals].sum(axis=0)
    return _Fitted(
        train=train,
        test=test,
        train_pull=pull,
        test_moment=held_out - test @ x,
        free=columns,
        inverse_cross=cho_solve(factor, train[columns]),
        left=energy - 2 * np.einsum("pk,pk->k", x, held_out) + np.einsum("pk,pk->k", x, test @ x),
    )


def _as_prior(evidence: Evidence, fold: Fold, columns: IntArray, priors: Priors) -> Array:
    """Precisions under which calibration errors that would leave their bounds come to lie at them, shape (F,).

    They stay as soft as that when a candidate joins, and come back from their bounds if it takes over.
    """
    train = evidence.gram[fold.train].sum(axis=0)[np.ix_(columns, columns)]
    pull = evidence.moment[fold.train][:, columns, 0].sum(axis=0)
    precision = priors.precision[columns]
    x = bounded(train, pull, precision, priors.low[columns], priors.high[columns])
    slope = pull - train @ x - precision * x
    at_bound = (x >= priors.high[columns]) | (x <= priors.low[columns])
    more = np.divide(slope, x, out=np.zeros_like(x), where=at_bound & (x != 0))
    return precision + np.maximum(more, 0.0)


def left_by_block(
    evidence: Evidence, folds: Sequence[Fold], columns: IntArray, priors: Priors, residual: int = 0
) -> Array:
    """Energy left in each block by a fit of `columns` to the blocks that are not left out with it, shape (B,)."""
    left = np.zeros(len(evidence.blocks))
    for fold in folds:
        gram, pull = evidence.gram[fold.train].sum(axis=0), evidence.moment[fold.train].sum(axis=0)[:, residual]
        x = bounded(
            gram[np.ix_(columns, columns)],
            pull[columns],
            priors.precision[columns],
            priors.low[columns],
            priors.high[columns],
        )
        for b in np.flatnonzero(fold.test):
            inner = evidence.gram[b][np.ix_(columns, columns)]
            left[b] = evidence.energy[b, residual] - 2 * x @ evidence.moment[b, columns, residual] + x @ inner @ x
    return left


def fitted(
    evidence: Evidence, columns: IntArray, priors: Priors, blocks: BoolArray | None = None, residual: int = 0
) -> Array:
    """Parameters of `columns` fitted to some blocks, or to all, shape (len(columns),)."""
    chosen = slice(None) if blocks is None else blocks
    gram, pull = evidence.gram[chosen].sum(axis=0), evidence.moment[chosen].sum(axis=0)[:, residual]
    return bounded(
        gram[np.ix_(columns, columns)],
        pull[columns],
        priors.precision[columns],
        priors.low[columns],
        priors.high[columns],
    )
