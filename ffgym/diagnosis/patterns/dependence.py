"""The catch-all: does a residual depend on a variable at all, in whatever way; distance correlation."""

from dataclasses import dataclass

import numpy as np
from scipy.stats import gumbel_r

from ffgym.core.types import Array, IntArray
from ffgym.diagnosis.patterns.functions import Variable
from ffgym.diagnosis.patterns.rows import Rows

MOST_ROWS = 400
"""Rows that are compared with each other; chosen: their pairs take a millisecond per shuffle."""

DRAWS = 60
"""Shuffles of the residual; chosen: mean and spread of their largest scores are then known to a tenth."""

_VARIABLES: tuple[Variable, ...] = ("angle", "speed", "acceleration", "load")


@dataclass(frozen=True, kw_only=True)
class Dependence:
    """A variable that a residual depends on, in a form that nobody knows."""

    variable: Variable
    joint: int | None
    """Whose variable it is; None for time."""
    correlation: float
    """Distance correlation, or that of neighbours in time, 0 to 1."""


def dependence(rows: Rows, values: Array, level: float, rng: np.random.Generator) -> Dependence | None:
    """The variable that values (R,) depend on most surely; None if shuffled values do as well with probability `level`.

    All variables, for the residual and for its size (noise may grow), are tested at once: the largest of their
    standardised covariances must be rare among those of shuffles, which follow the law of largest values. One row of
    each block is used, and rows are shuffled within their motion, so that what differs between motions is no
    dependence. A residual that wanders is not to be tested so: whatever moves slowly looks like it.

    Reference:
        Szekely, Rizzo, Bakirov (2007), Annals of Statistics 35(6), 2769-2794.
    """
    kept = rows.block_starts[:: max(1, -(-len(rows.block_starts) // MOST_ROWS))]
    names = [(variable, joint) for joint in range(len(rows.joints)) for variable in _VARIABLES]
    motion = rows.motion[kept]
    distances = np.stack([_distances(_ranks(getattr(rows.did, v)[kept, j], motion)).ravel() for v, j in names])
    kinds = np.stack([_distances(values[kept]), _distances(np.abs(values[kept]))])
    orders = [np.arange(len(kept)), *(_shuffled(motion, rng) for _ in range(DRAWS))]
    covariance = np.stack([_covariances(distances, kinds[:, order][:, :, order]) for order in orders])
    null = covariance[1:]
    spread = null.std(axis=0)
    score = np.divide(covariance - null.mean(axis=0), spread, out=np.zeros_like(covariance), where=spread > 0)
    if gumbel_r.sf(score[0].max(), *_gumbel(score[1:].max(axis=(1, 2)))) > level:
        return None
    kind, best = np.unravel_index(np.argmax(score[0]), score[0].shape)
    size = float(np.linalg.norm(distances[best]) * np.linalg.norm(kinds[kind]))
    return Dependence(
        variable=names[best][0],
        joint=names[best][1],
        correlation=float(np.sqrt(covariance[0, kind, best] / size)),
    )


def _gumbel(largest: Array) -> tuple[float, float]:
    """Place and scale of a Gumbel distribution by mean and spread of its values (D,)."""
    scale = float(largest.std()) * np.sqrt(6.0) / np.pi
    return float(largest.mean()) - np.euler_gamma * scale, max(scale, np.finfo(np.float64).tiny)


def _covariances(distances: Array, kinds: Array) -> Array:
    """Covariances (2, V) of the distances (V, R^2) of variables with those of the residual (2, R, R)."""
    covariances: Array = kinds.reshape(len(kinds), -1) @ distances.T
    return covariances


def _shuffled(motion: IntArray, rng: np.random.Generator) -> IntArray:
    """Order of rows in which those of each motion are shuffled among themselves."""
    return np.lexsort([rng.random(len(motion)), motion])


def _ranks(values: Array, motion: IntArray) -> Array:
    """Place of each value (R,) among those of its motion, 0 to 1, so that no motion's range hides the others'."""
    order = np.lexsort([values, motion])
    counts = np.bincount(motion)[motion]
    first = np.searchsorted(motion, motion)
    ranks = np.empty(len(values))
    ranks[order] = np.arange(len(values))
    placed: Array = (ranks - first) / counts
    return placed


def _distances(values: Array) -> Array:
    """Distances between all pairs of values (R,), less the means of rows and columns."""
    apart = np.abs(values[:, None] - values)
    mean = apart.mean(axis=0)
    centred: Array = apart - mean - mean[:, None] + mean.mean()
    return centred
