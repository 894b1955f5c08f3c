"""How firmly parameters are held near the description: as firmly as predicts what was not fitted."""

from dataclasses import dataclass

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array, IntArray
from ffgym.diagnosis.identification.rigid_body.problem import Problem

SPREADS = (0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0)
"""What is tried: from a description that is as good as a drawing to one that is a rule of thumb."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TradeOff:
    """Prediction of held-out rows by how firmly parameters were held."""

    spreads: Array
    """Relative standard deviations that were tried, shape (S,)."""
    errors: Array
    """RMS error of held-out rows in units of the motors' noise, shape (S,)."""
    chosen: float
    """The smallest spread that predicts as well as the best, within one standard error."""


def choose_spread(problem: Problem, folds: IntArray, spreads: tuple[float, ...] = SPREADS) -> TradeOff:
    """Choose by cross-validation: each fold is predicted from the others.

    The description is left only for a reason: of all spreads whose loss exceeds the least by no more than one standard
    error of their difference over the blocks, the smallest is taken.

    Args:
        problem: weighted equations.
        folds: fold of each block, shape (n_blocks,).
        spreads: what to try.

    Raises:
        FFGymError: if there is only one fold.

    Reference:
        Hastie, Tibshirani, Friedman (2009), The Elements of Statistical Learning, 7.10 (one-standard-error rule).
    """
    if len(np.unique(folds)) < 2:
        raise FFGymError("There is one block of rows only, so nothing can be held out: record for longer.")
    losses = np.array([_held_out(problem, folds, spread) for spread in spreads])
    total = losses.sum(axis=1)
    excess = losses - losses[np.argmin(total)]
    tie = excess.sum(axis=1) <= excess.std(axis=1, ddof=1) * np.sqrt(losses.shape[1])
    return TradeOff(
        spreads=np.array(spreads),
        errors=np.sqrt(total / problem.rows),
        chosen=float(spreads[int(np.argmax(tie))]),
    )


def _held_out(problem: Problem, folds: IntArray, spread: float) -> Array:
    """Loss of each block, predicted from the other folds, shape (n_blocks,)."""
    losses = np.zeros(len(folds))
    for fold in np.unique(folds):
        own = folds == fold
        losses[own] = problem.losses(problem.solve((~own).astype(np.float64), spread))[own]
    return losses
