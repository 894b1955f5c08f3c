"""Tests of dependence: forms on halves of the rows, any dependence at all, and wandering with time."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.diagnosis.patterns.forms import Periodic, Variable, VariableFunction, fit_columns
from ffgym.diagnosis.patterns.rows import PatternRows
from ffgym.diagnosis.settings import settings


@dataclass(frozen=True, kw_only=True, eq=False)
class FormTest:
    """Held-out test of one form of dependence on C residuals in B blocks that it was not fitted to."""

    candidate: VariableFunction | Periodic
    gain: Array
    """Energy that it removes from each block, shape (B, C)."""
    p: Array
    """Probability of a prediction as good without any dependence, shape (C,)."""


def judge_form(
    candidate: VariableFunction | Periodic, rows: PatternRows, values: Array, active: Sequence[int]
) -> FormTest:
    """Judge a form of dependence on centred values (R, C) of the components `active`, those that it may act on.

    A frequency is sought in the half that is fitted, too. Either direction is a valid test by itself; of the better one
    of two its probability doubles.
    """
    open_to = [c for c in active if candidate.may_act_on(rows, c)]
    gain, p = np.zeros((len(rows.block_starts), values.shape[1])), np.ones((2, values.shape[1]))
    if not open_to:
        return FormTest(candidate=candidate, gain=gain, p=p[0])
    measured = values[:, open_to]
    columns = rows.centre(candidate.columns(rows)) if isinstance(candidate, VariableFunction) else np.zeros((0, 0))
    # fit on one half, predict the other, and the other way round
    for judged in (0, 1):
        train, blocks = rows.half != judged, rows.block_half == judged
        if train.any() and blocks.any():
            if isinstance(candidate, VariableFunction):
                foretold = columns @ fit_columns(columns[train], measured[train])
            else:
                foretold = _predict_waves(candidate, rows, measured, train)
            agreement, size = (rows.by_block(foretold * other)[blocks] for other in (measured, foretold))
            gain[np.ix_(blocks, open_to)] = 2 * agreement - size
            # bounded by 1, so that a few large blocks are not the only ones that are heard: a block in which something
            # is foretold counts by its correlation, one in which little is, or little happens, less
            energy = rows.by_block(measured**2)[blocks]
            scale = np.sqrt(size * energy) + np.median(energy, axis=0) + np.finfo(np.float64).tiny
            p[judged, open_to] = compute_sign_probability(agreement / scale)
    return FormTest(candidate=candidate, gain=gain, p=np.minimum(1.0, 2 * p.min(axis=0)))


def _predict_waves(candidate: Periodic, rows: PatternRows, values: Array, train: BoolArray) -> Array:
    """Predict sines (R, C) with frequencies and amplitudes fitted to the rows of `train`."""
    foretold = np.zeros_like(values)
    for c, frequency in enumerate(candidate.search(rows, values, train) or ()):
        columns = rows.centre(candidate.columns(rows, frequency))
        foretold[:, c] = columns @ fit_columns(columns[train], values[train, c])
    return foretold


def compute_sign_probability(agreement: Array) -> Array:
    """Compute the probability (C,) of sums of (B, C) as large if each block's sign were even chance.

    Without dependence a prediction agrees with a block as often as it disagrees, however large the block's residual is,
    so that the self-normalised sum is about Student's t. Blocks in which nothing is predicted do not count.
    """
    squares = np.sum(agreement**2, axis=0)
    count = np.divide(squares**2, np.sum(agreement**4, axis=0), out=np.ones_like(squares), where=squares > 0)
    ratio = np.divide(np.sum(agreement, axis=0), np.sqrt(squares), out=np.zeros_like(squares), where=squares > 0)
    freedom = np.maximum(count - 1, 1e-3)
    t = ratio * np.sqrt(freedom / np.maximum(count - ratio**2, 1e-12))
    p: Array = np.maximum(scipy.stats.t.sf(t, freedom), np.exp2(-np.ceil(count)))  # no rarer than all signs alike
    return p


def choose_simplest(
    trials: Sequence[FormTest], rows: PatternRows, c: int, *, least: float, level: float
) -> FormTest | None:
    """Choose the simplest of the forms that explain component `c` as well as the best one; None if none is sure.

    A form that is sure removes the `least` energy or more, and does so by chance with a probability below `level`.
    """
    sure = [trial for trial in trials if trial.p[c] < level and trial.gain[:, c].sum() >= least]
    if not sure:
        return None
    best = max(sure, key=lambda trial: float(trial.gain[:, c].sum()))
    # forms that lose less than one standard error to the best one are as good
    less = [best.gain[:, c] - trial.gain[:, c] for trial in sure]
    error = [float(np.sqrt(np.sum((of_block - of_block.mean()) ** 2))) for of_block in less]
    equal = [trial for trial, lost, sigma in zip(sure, less, error, strict=True) if float(lost.sum()) <= sigma]
    return min(equal, key=lambda trial: (trial.candidate.complexity(rows), -float(trial.gain[:, c].sum())))


_VARIABLES: tuple[Variable, ...] = ("angle", "speed", "acceleration", "load")


@dataclass(frozen=True, kw_only=True)
class Dependence:
    """Variable that a residual depends on, in an unknown form."""

    variable: Variable
    joint: int | None
    """Joint whose variable it is; None for time."""
    correlation: float
    """Distance correlation, or that of neighbours in time, 0 to 1."""


def find_dependence(rows: PatternRows, values: Array, level: float, rng: np.random.Generator) -> Dependence | None:
    """Find the variable that values (R,) depend on most surely; None if shuffled values reach as much by chance.

    All variables, for the residual and for its size (noise may grow), are tested at once: the largest of their
    standardised covariances must be rare among those of shuffles, which follow the law of largest values. One row of
    each block is used, and rows are shuffled within their motion, so that what differs between motions is no
    dependence. A residual that wanders is not to be tested so: whatever moves slowly looks like it.

    Reference:
        Szekely, Rizzo, Bakirov (2007), Annals of Statistics 35(6), 2769-2794.
    """
    limits = settings().patterns
    kept = rows.block_starts[:: max(1, -(-len(rows.block_starts) // limits.most_rows))]
    names = [(variable, joint) for joint in range(len(rows.joints)) for variable in _VARIABLES]
    motion = rows.motion[kept]
    # distances of the residual and its size, and of all variables by rank
    distances = np.stack([_compute_distances(_rank(rows.did[v][kept, j], motion)).ravel() for v, j in names])
    kinds = np.stack([_compute_distances(values[kept]), _compute_distances(np.abs(values[kept]))])
    # order of rows in which those of each motion are shuffled among themselves
    orders = [
        np.arange(len(kept)),
        *(np.lexsort([rng.random(len(motion)), motion]) for _ in range(limits.draws)),
    ]
    covariance = np.stack([kinds[:, order][:, :, order].reshape(len(kinds), -1) @ distances.T for order in orders])
    # standardise by shuffles; the largest of them follow Gumbel's law
    null = covariance[1:]
    spread = null.std(axis=0)
    score = np.divide(covariance - null.mean(axis=0), spread, out=np.zeros_like(covariance), where=spread > 0)
    largest = score[1:].max(axis=(1, 2))
    scale = float(largest.std()) * np.sqrt(6.0) / np.pi
    place = float(largest.mean()) - np.euler_gamma * scale
    if scipy.stats.gumbel_r.sf(score[0].max(), place, max(scale, np.finfo(np.float64).tiny)) > level:
        return None
    kind, best = np.unravel_index(np.argmax(score[0]), score[0].shape)
    size = float(np.linalg.norm(distances[best]) * np.linalg.norm(kinds[kind]))
    return Dependence(
        variable=names[best][0], joint=names[best][1], correlation=float(np.sqrt(covariance[0, kind, best] / size))
    )


def _rank(values: Array, motion: IntArray) -> Array:
    """Rank each value (R,) among those of its motion, 0 to 1, so that no motion's range hides the others'."""
    order = np.lexsort([values, motion])
    counts = np.bincount(motion)[motion]
    first = np.searchsorted(motion, motion)
    ranks = np.empty(len(values))
    ranks[order] = np.arange(len(values))
    placed: Array = (ranks - first) / counts
    return placed


def _compute_distances(values: Array) -> Array:
    """Compute distances between all pairs of values (R,), less the means of rows and columns."""
    apart = np.abs(values[:, None] - values)
    mean = apart.mean(axis=0)
    centred: Array = apart - mean - mean[:, None] + mean.mean()
    return centred


def find_wandering(rows: PatternRows, values: Array, level: float) -> Dependence | None:
    """Find wandering of values (R,): blocks of a motion, some apart, agree in sign more than by chance; None if not."""
    limits = settings().patterns
    means, motion = rows.by_block(values[:, None])[:, 0], rows.motion[rows.block_starts]
    pairs = np.flatnonzero(motion[limits.apart :] == motion[: -limits.apart])
    before, after = means[pairs], means[pairs + limits.apart]
    size = np.abs(before * after)
    agreement = before * after / (size + np.median(size) + np.finfo(np.float64).tiny)
    if compute_sign_probability(agreement[:, None])[0] > level:
        return None
    alike = float(np.sum(before * after) / np.sqrt(np.sum(before**2) * np.sum(after**2)))
    return Dependence(variable="time", joint=None, correlation=max(alike, 0.0))
