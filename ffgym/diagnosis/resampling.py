"""Blocks of rows, the unit of resampling: a block bootstrap with its intervals, and folds of a cross-validation.

Blocks are long against what correlates their rows, so that each counts as an observation of its own.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ffgym.core.errors import FFGymError, check_number, check_whole
from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.diagnosis.settings import settings
from ffgym.logs.quality.signals import stretches

LEVEL = 0.9
"""Default probability of an interval."""

RESAMPLES = 400
"""Default number of resamples: the ends of a 90 % interval then scatter by a tenth of its half width."""
MOST_RESAMPLES = 100_000
"""Largest number of resamples; chosen, its ends scatter by less than a hundredth then."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Blocks:
    """Rows of data in blocks that are long against what correlates them, and the strata that blocks are drawn from."""

    of_row: IntArray
    """Block of each row, shape (T,); -1 for rows that are in none."""
    stratum: IntArray
    """Stratum of each block, e.g. its record or its speed, shape (n_blocks,). No stratum is lost in a resample."""

    def __post_init__(self) -> None:
        if not len(self.stratum):
            raise FFGymError("There are no rows to estimate from, so there are no blocks to resample.")

    @property
    def n_blocks(self) -> int:
        """Number of blocks."""
        return len(self.stratum)

    @property
    def n_resampled(self) -> int:
        """Number of blocks that are not alone in their stratum, so that resamples differ in them."""
        counts = np.bincount(self.stratum)
        return int(counts[counts > 1].sum())

    @classmethod
    def cut(cls, strata: Sequence[BoolArray], dt: float, duration: float) -> "Blocks":
        """Cut runs of rows that follow one another into equal blocks of about `duration` [s], at least one each.

        `strata` are the rows of each stratum, shape (T,), disjoint; rows are `dt` [s] apart.
        """
        length = max(1, round(check_number("block duration", duration, unit="s", low=0.0, open_low=True) / dt))
        of_row: IntArray = np.full(len(strata[0]) if strata else 0, -1, dtype=np.intp)
        stratum: list[int] = []
        for s, rows in enumerate(strata):
            for run in stretches(rows):
                n_rows = run.stop - run.start
                count = max(1, round(n_rows / length))
                of_row[run] = len(stratum) + _cut_evenly(n_rows, count)
                stratum += [s] * count
        return cls(of_row=of_row, stratum=np.array(stratum, dtype=np.intp))

    @classmethod
    def joined(cls, parts: Sequence["Blocks"]) -> "Blocks":
        """Blocks of data sets one after the other; strata of different sets differ."""
        rows, strata, blocks, count = [], [], 0, 0
        for part in parts:
            rows.append(np.where(part.of_row >= 0, part.of_row + blocks, -1))
            strata.append(part.stratum + count)
            blocks, count = blocks + part.n_blocks, count + int(part.stratum.max()) + 1
        return cls(of_row=np.concatenate(rows), stratum=np.concatenate(strata))

    def sums(self, values: Array) -> Array:
        """Sums of `values` (T, ...) over the rows of each block, shape (n_blocks, ...)."""
        inside = self.of_row >= 0
        total = np.zeros((self.n_blocks, *values.shape[1:]))
        np.add.at(total, self.of_row[inside], values[inside])
        return total

    def draw(self, rng: np.random.Generator) -> Array:
        """Draw how often each block counts in one resample, shape (n_blocks,).

        From each stratum of n blocks n - 1 are drawn with replacement and count n / (n - 1) times, so that the variance
        of a mean is that of the data, not (n - 1) / n of it; the one block of a stratum of one always counts once.

        Reference:
            Rao & Wu (1988), Journal of the American Statistical Association 83, 231-241.
        """
        counts = np.ones(self.n_blocks)
        for s in np.unique(self.stratum):
            own = np.flatnonzero(self.stratum == s)
            if len(own) > 1:
                n = len(own)
                counts[own] = rng.multinomial(n - 1, np.full(n, 1 / n)) * (n / (n - 1))
        return counts


def _cut_evenly(n_rows: int, count: int) -> IntArray:
    """Number `count` blocks of equal length from 0 on; block of each row, shape (n_rows,)."""
    return np.arange(n_rows) * count // n_rows


@dataclass(frozen=True)
class Pool:
    """Blocks without strata, of which a resample draws as many with replacement.

    This is the plain bootstrap, whose variance is too small by a share of 1 / n_blocks; `Blocks` serve few blocks.
    """

    n_blocks: int
    """Number of blocks."""

    def draw(self, rng: np.random.Generator) -> Array:
        """Draw how often each block counts in one resample, shape (n_blocks,)."""
        drawn = rng.integers(self.n_blocks, size=self.n_blocks)
        return np.bincount(drawn, minlength=self.n_blocks).astype(np.float64)


class Intervals(NamedTuple):
    """Ends of the intervals of parameters, shape (P,) each."""

    low: Array
    high: Array


def bootstrap(
    estimate: Callable[[Array], Array], blocks: Blocks | Pool, rng: np.random.Generator, n_resamples: int = RESAMPLES
) -> Array:
    """Estimates from resampled blocks, shape (n_resamples, P).

    Args:
        estimate: from how often each block counts, shape (n_blocks,), to parameters, shape (P,); ones give the
            estimate itself.
        blocks: of the rows that were estimated from.
        rng: draws the blocks of a resample, before it is estimated from.
        n_resamples: how many resamples.
    """
    count = check_whole("n_resamples", n_resamples, low=2, high=MOST_RESAMPLES)
    return np.stack([estimate(blocks.draw(rng)) for _ in range(count)])


def intervals(estimate: Array, resampled: Array, level: float = LEVEL, *, widened: float = 1.0) -> Intervals:
    """Compute percentile intervals of parameters.

    Args:
        estimate: parameters, shape (P,); an interval always holds it.
        resampled: what `bootstrap` gives, shape (B, P).
        level: probability.
        widened: factor on the distance of the ends from the estimate, for what resamples do not vary.

    Reference:
        Kuensch (1989), Annals of Statistics 17(3), for blocks; Davison & Hinkley (1997), Bootstrap Methods, ch. 5.
    """
    level = check_number("level", level, low=0.0, high=1.0, open_low=True)
    low, high = np.quantile(resampled, [(1 - level) / 2, (1 + level) / 2], axis=0)
    low, high = np.minimum(low, estimate), np.maximum(high, estimate)
    return Intervals(low=low - (widened - 1) * (estimate - low), high=high + (widened - 1) * (high - estimate))


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
        of_row[rows, m] = count + _cut_evenly(len(rows), n)
        # halves of the motion, and guards on both sides of the cut
        first = (n + 1) // 2
        motions += [m] * n
        halves += [0] * first + [1] * (n - first)
        guards += [n >= 6 and k in (first - 1, first) for k in range(n)]
        count += n
    return TimeBlocks(of_row=of_row, motion=np.array(motions), half=np.array(halves), guard=np.array(guards))


@dataclass(frozen=True, kw_only=True, eq=False)
class Fold:
    """Fold of a cross-validation: blocks to fit to, and held-out blocks to judge by; shape (B,) each."""

    train: BoolArray
    test: BoolArray


def make_motion_folds(blocks: TimeBlocks, count: int | None = None) -> list[Fold]:
    """Leave out each motion in turn, to test whether an explanation holds for others; empty for a single motion.

    A `count` below the number of motions leaves out groups of motions.
    """
    motions = np.unique(blocks.motion)
    if len(motions) < 2:
        return []
    group = np.searchsorted(motions, blocks.motion) % min(count or len(motions), len(motions))
    return [Fold(train=group != k, test=group == k) for k in range(int(group.max()) + 1)]


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
