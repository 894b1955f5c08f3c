"""Ranking of fitted structures by what they leave in rows that their numbers were not fitted to, and what ties.

The score of a structure is the mean square of ln(predicted / measured) over RMS rows that were held out, and over
fitted RMS rows as they are predicted without the rows of their own place. Rows of one cell (motion and radius) share
their causes, so cells are the blocks of the bootstrap.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.resampling import Pool, bootstrap, intervals
from ffgym.diagnosis.tables.error_table import ErrorTable
from ffgym.diagnosis.tables.structure_fit import StructureFit

FACTOR = 1.5
"""Factor within which a predicted error counts as right; chosen by the exam of this project."""

FITS = 0.8
"""Share of RMS rows within that factor, fitted and held out each, from which a structure fits; chosen."""


@dataclass(frozen=True, kw_only=True)
class RankedStructure:
    """Structure with what it leaves."""

    fit: StructureFit
    score: float
    """Mean square of ln(predicted / measured) in rows that it was not fitted to."""
    behind: float
    """Score beyond that of the best structure."""
    behind_low: float
    """Lower end of the interval of 90 % of that difference."""
    behind_high: float
    is_tied: bool
    """True if the best structure is not better for certain."""
    median_abs_log: float
    """Median of |ln(predicted / measured)| over fitted RMS rows."""
    held_out_median_abs_log: float
    """The same over held-out RMS rows; nan without such rows."""
    left_out_median_abs_log: float
    """The same over fitted RMS rows, each predicted without its place; nan with one place alone."""
    fitted_within_1_5: int
    """Fitted RMS rows within a factor 1.5."""
    fitted_rms: int
    """Number of them."""
    left_out_within_1_5: int
    """Fitted RMS rows within that factor, each predicted without its place."""
    held_out_within_1_5: int
    held_out_rms: int
    fitted_max_within_1_5: int
    """Fitted rows of largest errors within a factor 1.5."""
    sign_right: int
    """Cells in which the law that is asked about helps, or harms, as measured."""
    sign_cells: int
    sign_ratios: tuple[float, ...]
    """Predicted RMS error with that law over the one without compensation, by cell."""
    sign_measured: tuple[float, ...]
    """The same as measured."""

    @property
    def fits(self) -> bool:
        """Tell whether it explains the table."""
        fitted = self.fitted_within_1_5 >= FITS * self.fitted_rms
        return fitted and self.held_out_within_1_5 >= FITS * self.held_out_rms


def rank_structures(table: ErrorTable, fits: Sequence[StructureFit], seed: int) -> list[RankedStructure]:
    """Rank structures, the best first.

    Args:
        table: what they were fitted to.
        fits: one or more.
        seed: of the resamples.
    """
    cells = [row.cell for row in table.rows]
    names = list(dict.fromkeys(cells))
    block = np.array([names.index(cell) for cell in cells])
    squares = np.stack([_unseen_squares(table, fit) for fit in fits])
    counted = np.isfinite(squares).all(axis=0)
    if not counted.any():  # neither held-out rows nor a second place: the rows of the fit must do
        squares = np.stack([np.where(table.is_rms, _logs(table, fit.predicted_mm) ** 2, np.nan) for fit in fits])
        counted = table.is_rms
    scores = squares[:, counted].mean(axis=1)
    best = int(np.argmin(scores))
    # differences from the best, resampled by cells
    sums = np.stack([np.bincount(block[counted], row[counted], minlength=len(names)) for row in squares])
    sizes = np.bincount(block[counted], minlength=len(names))

    def behind(counts: Array) -> Array:
        return np.asarray((sums - sums[best]) @ counts / max(float(sizes @ counts), 1.0))

    drawn = bootstrap(behind, Pool(len(names)), np.random.default_rng(seed))
    low, high = intervals(scores - scores[best], drawn)
    ranked = [
        _describe(table, fit, float(scores[i]), float(scores[i] - scores[best]), float(low[i]), float(high[i]))
        for i, fit in enumerate(fits)
    ]
    return sorted(ranked, key=lambda one: one.score)


def _logs(table: ErrorTable, predicted: Sequence[float] | Array) -> Array:
    values = np.where(np.isfinite(predicted), predicted, np.nan)
    logs: Array = np.log(values / table.values)
    return logs


def _unseen_squares(table: ErrorTable, fit: StructureFit) -> Array:
    """Squares of logarithms in RMS rows that the numbers were not fitted to, nan elsewhere, shape (R,)."""
    predicted = np.where(table.fitted, fit.left_out_mm, fit.predicted_mm)
    return np.where(table.is_rms, _logs(table, predicted) ** 2, np.nan)


def _describe(
    table: ErrorTable, fit: StructureFit, score: float, behind: float, low: float, high: float
) -> RankedStructure:
    logs, left_out = np.abs(_logs(table, fit.predicted_mm)), np.abs(_logs(table, fit.left_out_mm))
    fitted, held_out = table.fitted & table.is_rms, ~table.fitted & table.is_rms
    largest = table.fitted & ~table.is_rms

    def within(values: Array) -> int:
        return int(np.sum(values < np.log(FACTOR)))

    pairs = table.sign_pairs()
    predicted = [fit.predicted_mm[a] / fit.predicted_mm[b] for a, b in pairs]
    measured = [float(table.values[a] / table.values[b]) for a, b in pairs]
    return RankedStructure(
        fit=fit,
        score=score,
        behind=behind,
        behind_low=low,
        behind_high=high,
        is_tied=low <= 0,
        median_abs_log=_median(logs[fitted]),
        held_out_median_abs_log=_median(logs[held_out]),
        left_out_median_abs_log=_median(left_out[fitted]),
        fitted_within_1_5=within(logs[fitted]),
        fitted_rms=int(fitted.sum()),
        left_out_within_1_5=within(left_out[fitted]),
        held_out_within_1_5=within(logs[held_out]),
        held_out_rms=int(held_out.sum()),
        fitted_max_within_1_5=within(logs[largest]),
        sign_right=sum((a < 1) == (b < 1) for a, b in zip(predicted, measured, strict=True)),
        sign_cells=len(pairs),
        sign_ratios=tuple(predicted),
        sign_measured=tuple(measured),
    )


def _median(values: Array) -> float:
    finite = values[np.isfinite(values)]
    return float(np.median(finite)) if len(finite) else float("nan")
