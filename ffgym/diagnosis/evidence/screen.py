r"""Held-out gains of many candidates at once.

With calibration columns n and those of one candidate c, a fold's training sums give

.. math::
    V = A^{-1} G_{nc}, \quad x = S^{-1} (m_c - V^T m_n), \quad S = G_{cc} - V^T G_{nc} + P_c, \quad A = G_{nn} + P_n

and what the candidate removes from the blocks that were left out is

.. math:: D = 2 x^T w - x^T W x, \quad w = m'_c - V^T m'_n, \quad W = [-V; 1]^T G' [-V; 1]

of their residual moments m' after the calibration alone. Only sums enter, for the log and for noise alike.
"""

from collections.abc import Iterator, Sequence
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
    alike = _alike(candidates)
    for train, test in _sums(evidence, folds):
        for residuals, precision in (
            (log, _as_prior(train, calibration, priors)),
            (noise, priors.precision[calibration]),
        ):
            if residuals.start == residuals.stop:
                continue
            fitted = _fit(train.of(residuals), test.of(residuals), calibration, precision)
            left[residuals] += fitted.left
            for chosen, columns, one_sided in alike:
                gain[chosen, residuals] += fitted.gains(columns, one_sided)
    return Screened(gain=gain, left=left)


def _alike(candidates: Sequence[Candidate]) -> list[tuple[IntArray, IntArray, BoolArray]]:
    """Candidates with equally many columns together: their places, their columns (C, S), and which have one sign."""
    sizes = np.array([len(candidate.columns) for candidate in candidates])
    found = []
    for size in np.unique(sizes):
        places = np.flatnonzero(sizes == size)
        chosen = [candidates[int(i)] for i in places]
        columns = np.stack([candidate.columns for candidate in chosen])
        found.append((places, columns, np.array([candidate.one_sided for candidate in chosen])))
    return found


@dataclass(frozen=True, kw_only=True, eq=False)
class _Sums:
    """Of some blocks."""

    gram: Array
    moment: Array
    energy: Array

    def of(self, residuals: slice) -> "_Sums":
        """Those of some residuals."""
        return _Sums(gram=self.gram, moment=self.moment[:, residuals], energy=self.energy[residuals])


def _sums(evidence: Evidence, folds: Sequence[Fold]) -> Iterator[tuple[_Sums, _Sums]]:
    """Of what each fold fits to and judges by; blocks that are always in or out together are summed once."""
    member = np.array([rows for fold in folds for rows in (fold.train, fold.test)])
    kinds, of_block = np.unique(member, axis=1, return_inverse=True)
    of_block = of_block.ravel()
    gram = evidence.stack.grouped(of_block)
    moment, energy = (
        np.stack([values[of_block == k].sum(axis=0) for k in range(kinds.shape[1])])
        for values in (evidence.moment, evidence.energy)
    )

    def summed(chosen: BoolArray) -> _Sums:
        return _Sums(
            gram=gram[chosen].sum(axis=0), moment=moment[chosen].sum(axis=0), energy=energy[chosen].sum(axis=0)
        )

    for train, test in zip(kinds[::2], kinds[1::2], strict=True):
        yield summed(train), summed(test)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Fitted:
    """Calibration fitted to a fold's training blocks; what all columns are beside it, there and in what is left out."""

    inner: Array
    """S without the prior, shape (P, P)."""
    size: Array
    """W, shape (P, P)."""
    pull: Array
    """Shape (P, K)."""
    held_out: Array
    """w, shape (P, K)."""
    left: Array

    def gains(self, columns: IntArray, one_sided: BoolArray) -> Array:
        """Energy that candidates with `columns` (C, S) remove from the blocks left out, shape (C, K)."""
        rows, others = columns[:, :, None], columns[:, None, :]
        x = np.linalg.solve(self.inner[rows, others] + _WIDE**-2 * np.eye(columns.shape[1]), self.pull[columns])
        x[one_sided] = np.maximum(x[one_sided], 0.0)
        gained: Array = np.sum(x * (2 * self.held_out[columns] - np.matmul(self.size[rows, others], x)), axis=1)
        return gained


def _fit(train: _Sums, test: _Sums, columns: IntArray, precision: Array) -> _Fitted:
    factor = cho_factor(train.gram[np.ix_(columns, columns)] + np.diag(precision))
    x = np.zeros_like(train.moment)
    x[columns] = cho_solve(factor, train.moment[columns])
    v = cho_solve(factor, train.gram[columns])
    rest = test.moment - test.gram @ x
    cross = v.T @ test.gram[columns]
    return _Fitted(
        inner=train.gram - v.T @ train.gram[columns],
        size=test.gram - cross - cross.T + v.T @ test.gram[np.ix_(columns, columns)] @ v,
        pull=train.moment - v.T @ train.moment[columns],
        held_out=rest - v.T @ rest[columns],
        left=test.energy - np.sum(x * (test.moment + rest), axis=0),
    )


def _as_prior(fold: _Sums, columns: IntArray, priors: Priors) -> Array:
    """Precisions under which calibration errors that would leave their bounds come to lie at them, shape (F,).

    They stay as soft as that when a candidate joins, and come back from their bounds if it takes over.
    """
    train, pull = fold.gram[np.ix_(columns, columns)], fold.moment[columns, 0]
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
