"""Residuals and columns in one layout: rows of all channels, weighted by the noise floor, cut into blocks of time."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ffgym.diagnosis.residual import Channel
from ffgym.diagnosis.signatures.column import Parts
from ffgym.types import Array, BoolArray, IntArray

BLOCK = 1.0
"""Length of a block [s], the unit of resampling and of what is left out; long against the low-pass, 50 ms, and against
the swing of an arm, 0.3 s."""

_FEW = 0.25
"""Share of a block's rows that must be there for it to be one of its own; else it joins the block before."""

Values = Mapping[tuple[Channel, int], Array]
"""By channel and component: (R, M) or (R, M, K)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Blocks:
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


def blocks_of(valid: BoolArray, row_dt: float) -> Blocks:
    """Blocks of `valid` rows (R, M), `row_dt` [s] apart."""
    of_row = np.full(valid.shape, -1, dtype=np.intp)
    motions, halves, guards, count = [], [], [], 0
    for m in range(valid.shape[1]):
        rows = np.flatnonzero(valid[:, m])
        if not len(rows):
            continue
        per_block = max(1, round(BLOCK / row_dt))
        n = max(2 if len(rows) > 1 else 1, round(len(rows) / per_block))
        place = np.minimum(np.arange(len(rows)) * n // len(rows), n - 1)
        of_row[rows, m] = count + place
        first = (n + 1) // 2
        motions += [m] * n
        halves += [0] * first + [1] * (n - first)
        guards += [n >= 6 and k in (first - 1, first) for k in range(n)]
        count += n
    return Blocks(of_row=of_row, motion=np.array(motions), half=np.array(halves), guard=np.array(guards))


@dataclass(frozen=True, kw_only=True, eq=False)
class Evidence:
    r"""Sums over blocks of a regression :math:`r = A x`, weighted rows of all channels together.

    All statistics are functions of these few numbers, so that they cost nothing beside the replays.
    """

    blocks: Blocks
    gram: Array
    """A^T A, shape (B, P, P)."""
    moment: Array
    """A^T r, shape (B, P, K), for K residuals: that of the log first, then those of noise."""
    energy: Array
    """r^T r, shape (B, K)."""
    rows: Array
    """Number of rows of all components, shape (B,): what the energy of noise alone would be."""
    n_components: int
    """Components of all channels."""


def evidence_of(blocks: Blocks, columns: Sequence[Parts], residuals: Values, weights: Values) -> Evidence:
    """Sums for columns (R, M) per component, residuals (R, M, K), and weights (M,) or (R, M) per component.

    Rows of weight 0 do not count.
    """
    n_blocks, n_columns = len(blocks), len(columns)
    n_residuals = next(iter(residuals.values())).shape[2]
    gram = np.zeros((n_blocks, n_columns, n_columns))
    moment = np.zeros((n_blocks, n_columns, n_residuals))
    energy, rows = np.zeros((n_blocks, n_residuals)), np.zeros(n_blocks)
    order = [np.flatnonzero(blocks.of_row == b) for b in range(n_blocks)]
    for key, residual in residuals.items():
        have = [i for i, column in enumerate(columns) if key in column]
        weight = np.broadcast_to(weights[key], residual.shape[:2])[..., None]
        counts = weight.ravel()
        flat_r = (residual * weight).reshape(-1, n_residuals)
        flat_a = (
            np.stack([columns[i][key] * weight[..., 0] for i in have], axis=-1).reshape(-1, len(have)) if have else None
        )
        for b, of_block in enumerate(order):
            r = flat_r[of_block]
            energy[b] += np.einsum("rk,rk->k", r, r)
            rows[b] += np.count_nonzero(counts[of_block])
            if flat_a is not None:
                a = flat_a[of_block]
                gram[b][np.ix_(have, have)] += a.T @ a
                moment[b][have] += a.T @ r
    return Evidence(blocks=blocks, gram=gram, moment=moment, energy=energy, rows=rows, n_components=len(residuals))
