"""Normal equations of weighted rows, summed by blocks of time, and folds of blocks that are left out in turn.

A linear fit needs A^T A, A^T r and r^T r only. They are kept for each block, so that any subset of the log, as a
fold or a bootstrap resample, is a sum of blocks; the rows themselves are passed once.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.diagnosis.perturbation import Parts
from ffgym.diagnosis.residual import Channel
from ffgym.diagnosis.settings import settings

Values = Mapping[tuple[Channel, int], Array]
"""By channel and component: (R, M) or (R, M, K)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TimeBlocks:
    """Blocks of rows: each of one motion, and of one half of it."""

    of_row: IntArray
    """Block of each row, -1 for none, shape (R, M)."""
    motion: IntArray
    """Motion of each block, shape (B,)."""
    half: IntArray
    """0 for blocks of the first half of their motion, 1 for those of the second, shape (B,)."""
    guard: BoolArray
    """Blocks on either side of the cut between the halves, shape (B,)."""

    def __len__(self) -> int:
        return len(self.motion)

    @cached_property
    def order(self) -> IntArray:
        """Places, in (R, M) laid out flat, of the rows that are of blocks: one block after the other."""
        flat = self.of_row.ravel()
        places = np.argsort(flat, kind="stable")
        return places[np.count_nonzero(flat < 0) :]

    @cached_property
    def slices(self) -> list[slice]:
        """Slices of the rows of each block in that order."""
        ends = np.cumsum(np.bincount(self.of_row[self.of_row >= 0], minlength=len(self)))
        return [slice(int(start), int(end)) for start, end in zip((0, *ends[:-1]), ends, strict=True)]

    def merge(self) -> "TimeBlocks":
        """Merge blocks of the same part of a motion: the fewest of which halves and motions can be left out."""
        parts = np.stack([self.motion, self.half, self.guard], axis=1).astype(np.intp)
        kinds, kind = np.unique(parts, axis=0, return_inverse=True)
        return TimeBlocks(
            of_row=np.where(self.of_row >= 0, kind[self.of_row], -1),
            motion=kinds[:, 0],
            half=kinds[:, 1],
            guard=kinds[:, 2].astype(np.bool_),
        )


def cut_blocks(valid: BoolArray, row_dt: float) -> TimeBlocks:
    """Cut `valid` rows (R, M), `row_dt` [s] apart, into blocks."""
    limits = settings().blocks
    of_row = np.full(valid.shape, -1, dtype=np.intp)
    motions, halves, guards, count = [], [], [], 0
    for m in range(valid.shape[1]):
        # blocks of equal numbers of rows, of a second or so; two at least
        rows = np.flatnonzero(valid[:, m])
        if not len(rows):
            continue
        per_block = max(1, round(limits.length / row_dt), round(np.count_nonzero(valid) / limits.most))
        n = max(2 if len(rows) > 1 else 1, round(len(rows) / per_block))
        place = np.minimum(np.arange(len(rows)) * n // len(rows), n - 1)
        of_row[rows, m] = count + place
        # halves of the motion, and guards on both sides of the cut
        first = (n + 1) // 2
        motions += [m] * n
        halves += [0] * first + [1] * (n - first)
        guards += [n >= 6 and k in (first - 1, first) for k in range(n)]
        count += n
    return TimeBlocks(of_row=of_row, motion=np.array(motions), half=np.array(halves), guard=np.array(guards))


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


@dataclass(frozen=True, kw_only=True, eq=False)
class Fold:
    """Fold of a cross-validation: blocks to fit to, and held-out blocks to judge by; shape (B,) each."""

    train: BoolArray
    test: BoolArray


def make_motion_folds(blocks: TimeBlocks) -> list[Fold]:
    """Leave out each motion in turn, to test whether an explanation holds for others; empty for a single motion."""
    motions = np.unique(blocks.motion)
    if len(motions) < 2:
        return []
    return [Fold(train=blocks.motion != m, test=blocks.motion == m) for m in motions]


def make_half_folds(blocks: TimeBlocks) -> list[Fold]:
    """Leave out each half of each motion in turn: the only split that can judge what one motion alone excites.

    Blocks on either side of the cut are not fitted to when the other half is judged, so that nothing leaks over it.
    """
    found = []
    for m in np.unique(blocks.motion):
        for half in (0, 1):
            test = (blocks.motion == m) & (blocks.half == half)
            near = blocks.guard & (blocks.motion == m)
            if test.any():
                found.append(Fold(train=~test & ~near, test=test))
    return found
