"""Columns fitted to blocks of rows, within their bounds."""

from collections.abc import Sequence

import numpy as np

from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.diagnosis.evidence.folds import Fold
from ffgym.diagnosis.evidence.priors import Priors
from ffgym.diagnosis.evidence.solve import bounded
from ffgym.diagnosis.evidence.stack import Evidence


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
