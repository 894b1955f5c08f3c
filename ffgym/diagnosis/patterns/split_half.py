"""Tests of forms of dependence: fitted on one half of the rows, judged on the other, and the other way round."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import t as student

from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.patterns.candidate import Fixed, Periodic, fit
from ffgym.diagnosis.patterns.rows import Rows


@dataclass(frozen=True, kw_only=True, eq=False)
class Trial:
    """How well one form of dependence foretells C residuals in B blocks that it was not fitted to."""

    candidate: Fixed | Periodic
    gain: Array
    """Energy that it removes from each block, shape (B, C)."""
    p: Array
    """Probability of a prediction as good without any dependence, shape (C,)."""


def tried(candidate: Fixed | Periodic, rows: Rows, values: Array, active: Sequence[int]) -> Trial:
    """Judge a form of dependence on centred values (R, C) of the components `active`, those that it may act on.

    A frequency is sought in the half that is fitted, too. Either direction is a valid test by itself; of the better one
    of two its probability doubles.
    """
    open_to = [c for c in active if candidate.may_act_on(rows, c)]
    gain, p = np.zeros((len(rows.block_starts), values.shape[1])), np.ones((2, values.shape[1]))
    if not open_to:
        return Trial(candidate=candidate, gain=gain, p=p[0])
    measured = values[:, open_to]
    foretell = _foretelling(candidate, rows, measured)
    for judged in (0, 1):
        train, blocks = rows.half != judged, rows.block_half == judged
        if train.any() and blocks.any():
            foretold = foretell(train)
            agreement, size = (rows.by_block(foretold * other)[blocks] for other in (measured, foretold))
            gain[np.ix_(blocks, open_to)] = 2 * agreement - size
            p[judged, open_to] = symmetric_test(_bounded(agreement, size, rows.by_block(measured**2)[blocks]))
    return Trial(candidate=candidate, gain=gain, p=np.minimum(1.0, 2 * p.min(axis=0)))


def _foretelling(candidate: Fixed | Periodic, rows: Rows, values: Array) -> Callable[[BoolArray], Array]:
    """What a form says of all rows (R, C) when it is fitted to some of them (R,)."""
    if isinstance(candidate, Fixed):
        columns = rows.centred(candidate.columns(rows))
        return lambda train: columns @ fit(columns[train], values[train])
    return lambda train: _waves(candidate, rows, values, train)


def _waves(candidate: Periodic, rows: Rows, values: Array, train: BoolArray) -> Array:
    """Sines (R, C) whose frequencies and amplitudes are those of some rows."""
    foretold = np.zeros_like(values)
    for c, frequency in enumerate(candidate.search(rows, values, train) or ()):
        columns = rows.centred(candidate.columns(rows, frequency))
        foretold[:, c] = columns @ fit(columns[train], values[train, c])
    return foretold


def _bounded(agreement: Array, size: Array, energy: Array) -> Array:
    """Agreement of each block (B, C), bounded by 1, so that a few large blocks are not the only ones that are heard.

    A block in which something is foretold counts by its correlation, one in which little is, or little happens, less.
    """
    bounded: Array = agreement / (np.sqrt(size * energy) + np.median(energy, axis=0) + np.finfo(np.float64).tiny)
    return bounded


def symmetric_test(agreement: Array) -> Array:
    """Probability (C,) that sums of (B, C) come out as large if each block's sign were even chance.

    Without dependence a prediction agrees with a block as often as it disagrees, however large the block's residual is,
    so that the self-normalised sum is about Student's t. Blocks in which nothing is predicted do not count.
    """
    squares = np.sum(agreement**2, axis=0)
    count = np.divide(squares**2, np.sum(agreement**4, axis=0), out=np.ones_like(squares), where=squares > 0)
    ratio = np.divide(np.sum(agreement, axis=0), np.sqrt(squares), out=np.zeros_like(squares), where=squares > 0)
    freedom = np.maximum(count - 1, 1e-3)
    t = ratio * np.sqrt(freedom / np.maximum(count - ratio**2, 1e-12))
    p: Array = np.maximum(student.sf(t, freedom), np.exp2(-np.ceil(count)))  # no rarer than all signs alike
    return p


def best_of(trials: Sequence[Trial], rows: Rows, c: int, *, least: float, level: float) -> Trial | None:
    """The simplest of the forms that explain component `c` as well as the best one; None if none is sure.

    Args:
        trials: of all forms.
        rows: what they were judged on.
        c: number of the component.
        least: energy that a form must remove.
        level: largest probability that a form may have by chance.
    """
    sure = [trial for trial in trials if trial.p[c] < level and trial.gain[:, c].sum() >= least]
    if not sure:
        return None
    best = max(sure, key=lambda trial: float(trial.gain[:, c].sum()))
    equal = [trial for trial in sure if _as_good(trial.gain[:, c], best.gain[:, c])]
    return min(equal, key=lambda trial: (trial.candidate.complexity(rows), -float(trial.gain[:, c].sum())))


def _as_good(gain: Array, best: Array) -> bool:
    """Whether blocks (B,) do not tell a form from the best one: it loses less than one standard error."""
    less = best - gain
    return float(less.sum()) <= float(np.sqrt(np.sum((less - less.mean()) ** 2)))
