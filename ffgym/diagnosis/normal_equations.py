"""Normal equations of weighted rows, summed by blocks of time.

A linear fit needs A^T A, A^T r and r^T r only. They are kept for each block, so that any subset of the log, as a
fold or a bootstrap resample, is a sum of blocks; the rows themselves are passed once.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ffgym.core.types import Array, IntArray
from ffgym.diagnosis.perturbation import Parts
from ffgym.diagnosis.resampling import TimeBlocks
from ffgym.diagnosis.residual import Channel

Values = Mapping[tuple[Channel, int], Array]
"""Arrays by channel and component: (R, M) or (R, M, K)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _Columns:
    """Weighted columns in one component, rows in the order of their blocks."""

    at: IntArray
    """Their places among all columns."""
    rows: Array
    """Shape (S, len(at))."""


@dataclass(frozen=True, kw_only=True, eq=False)
class DesignMatrix:
    """Design matrix: weighted columns with their products, made once for many residuals."""

    blocks: TimeBlocks
    weights: Values
    """(M,) or (R, M) per component; rows of weight 0 do not count."""
    parts: Mapping[tuple[Channel, int], tuple[_Columns, ...]]
    gram: Array
    """A^T A, shape (B, P, P)."""

    def beside(self, columns: Sequence[Parts], scale: Array | None = None) -> "DesignMatrix":
        """Append `columns`, (R, M) per component each, times `scale` (len(columns),)."""
        n, more = self.gram.shape[1], len(columns)
        gram = np.zeros((len(self.blocks), n + more, n + more))
        gram[:, :n, :n] = self.gram
        parts = dict(self.parts)
        # products of new columns with old and new ones, one component after the other
        for key, weight in self.weights.items():
            have = [i for i, column in enumerate(columns) if key in column]
            if not have:
                continue
            rows = np.stack([self._in_order(columns[i][key] * weight) for i in have], axis=-1)
            if scale is not None:
                rows *= scale[have]
            new = _Columns(at=n + np.array(have), rows=rows)
            for old in (*parts.get(key, ()), new):
                self._add_products(gram, old, new)
            parts[key] = (*parts.get(key, ()), new)
        return DesignMatrix(blocks=self.blocks, weights=self.weights, parts=parts, gram=gram)

    def form_equations(self, residuals: Values) -> "NormalEquations":
        """Form normal equations with K residuals, (R, M, K) per component."""
        n_residuals = next(iter(residuals.values())).shape[2]
        moment = np.zeros((len(self.blocks), self.gram.shape[1], n_residuals))
        energy, counted = np.zeros((len(self.blocks), n_residuals)), np.zeros(len(self.blocks))
        for key, residual in residuals.items():
            weight = np.broadcast_to(self.weights[key], residual.shape[:2])
            flat, counts = self._in_order(residual * weight[..., None]), self._in_order(weight)
            for b, own in enumerate(self.blocks.slices):
                r = flat[own]
                energy[b] += np.einsum("rk,rk->k", r, r)
                counted[b] += np.count_nonzero(counts[own])
                for columns in self.parts.get(key, ()):
                    moment[b, columns.at] += columns.rows[own].T @ r
        return NormalEquations(design=self, moment=moment, energy=energy, rows=counted, n_components=len(residuals))

    def energy_of(self, places: IntArray, x: Array) -> dict[tuple[Channel, int], float]:
        """Compute the energy of what some columns, times `x`, change in each component."""
        found = {}
        for key, parts in self.parts.items():
            total = np.zeros(len(parts[0].rows))
            for columns in parts:
                here, there = np.nonzero(columns.at[:, None] == places)
                total += columns.rows[:, here] @ x[there]
            found[key] = float(total @ total)
        return found

    def _in_order(self, rows: Array) -> Array:
        """Order rows (R, M, ...) that are of blocks, one block after the other, (S, ...)."""
        ordered: Array = rows.reshape(-1, *rows.shape[2:])[self.blocks.order]
        return ordered

    def _add_products(self, gram: Array, old: _Columns, new: _Columns) -> None:
        """Add products of two sets of columns, which may be the same one."""
        products = np.stack([old.rows[own].T @ new.rows[own] for own in self.blocks.slices])
        gram[:, old.at[:, None], new.at] += products
        if old is not new:
            gram[:, new.at[:, None], old.at] += products.transpose(0, 2, 1)


@dataclass(frozen=True, kw_only=True, eq=False)
class NormalEquations:
    r"""Normal equations by blocks of a regression :math:`r = A x`, weighted rows of all channels together.

    All statistics are functions of these few numbers, so that they cost nothing beside the replays.
    """

    design: DesignMatrix
    """The columns A."""
    moment: Array
    """A^T r, shape (B, P, K), for K residuals: that of the log first, then those of noise."""
    energy: Array
    """r^T r, shape (B, K)."""
    rows: Array
    """Number of rows of all components, shape (B,): what the energy of noise alone would be."""
    n_components: int
    """Components of all channels."""

    @property
    def blocks(self) -> TimeBlocks:
        """Blocks of rows."""
        return self.design.blocks

    @property
    def gram(self) -> Array:
        """A^T A, shape (B, P, P)."""
        return self.design.gram


def build_design_matrix(
    blocks: TimeBlocks, columns: Sequence[Parts], weights: Values, scale: Array | None = None
) -> DesignMatrix:
    """Weight columns (R, M) per component by (M,) or (R, M) per component, times `scale` (len(columns),)."""
    none = DesignMatrix(blocks=blocks, weights=weights, parts={}, gram=np.zeros((len(blocks), 0, 0)))
    return none.beside(columns, scale)
