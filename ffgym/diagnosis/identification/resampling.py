"""How sure an estimate is: intervals from resampled blocks of rows, and whether the data tell it at all."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from ffgym.core.errors import FFGymError, check_number, check_whole
from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.logs.quality.signals import stretches

LEVEL = 0.9
"""Default probability of an interval."""

RESAMPLES = 400
"""Default number of resamples: the ends of a 90 % interval then scatter by a tenth of its half width."""


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
                of_row[run] = len(stratum) + np.arange(n_rows) * count // n_rows
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
        """How often each block counts in one resample, shape (n_blocks,).

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


class Intervals(NamedTuple):
    """Ends of the intervals of parameters, shape (P,) each."""

    low: Array
    high: Array


def bootstrap(
    estimate: Callable[[Array], Array], blocks: Blocks, rng: np.random.Generator, n_resamples: int = RESAMPLES
) -> Array:
    """Estimates from resampled blocks, shape (n_resamples, P).

    Args:
        estimate: from how often each block counts, shape (n_blocks,), to parameters, shape (P,); ones give the
            estimate itself.
        blocks: of the rows that were estimated from.
        rng: draws the blocks.
        n_resamples: how many resamples.
    """
    count = check_whole("n_resamples", n_resamples, low=2)
    return np.stack([estimate(blocks.draw(rng)) for _ in range(count)])


def intervals(estimate: Array, resampled: Array, level: float = LEVEL) -> Intervals:
    """Percentile intervals of parameters.

    Args:
        estimate: parameters, shape (P,); an interval always holds it.
        resampled: what `bootstrap` gives, shape (B, P).
        level: probability.

    Reference:
        Kuensch (1989), Annals of Statistics 17(3), for blocks; Davison & Hinkley (1997), Bootstrap Methods, ch. 5.
    """
    level = check_number("level", level, low=0.0, high=1.0, open_low=True)
    low, high = np.quantile(resampled, [(1 - level) / 2, (1 + level) / 2], axis=0)
    return Intervals(low=np.minimum(low, estimate), high=np.maximum(high, estimate))


Status = Literal["identified", "given", "wide", "at bound", "not excited"]
"""identified: the value is the data's; given: by the caller; of the others the data do not tell the value: its interval
is wide, it lies at a bound, or no motion excites it. For them the value before stays."""

WIDE = 0.5
"""Half width of an interval, relative to the value, from which it counts as wide."""


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """One parameter of one joint."""

    name: str
    """As in the description, e.g. 'friction.coulomb'."""
    joint: str
    unit: str
    side: str
    """'motor' or 'link'."""
    value: float
    """To be used from now on: the identified one, or the one before where the status says so."""
    low: float
    """Lower end of the interval; 0 where there is none."""
    high: float
    """Upper end of the interval; inf where there is none."""
    prior: float
    """Value of the description before."""
    status: Status
    reason: str = ""
    """Why it is not identified."""

    @property
    def is_identified(self) -> bool:
        """Whether the value is the data's."""
        return self.status == "identified"


def judged(
    value: float, low: float, high: float, *, scale: float, excited: str, at_bound: bool = False
) -> tuple[Status, str]:
    """Status of an estimate with its interval, and the reason.

    A parameter below `scale` does not matter; `excited` says what the motions lack to tell it, '' if nothing.
    """
    if excited:
        return "not excited", excited
    if at_bound:
        return "at bound", f"the fit ends at the bound {value:.4g} of its range"
    half = (high - low) / 2
    if not np.isfinite(half):
        raise FFGymError(f"The interval [{low}, {high}] of an estimate must be finite.")
    if half > WIDE * max(abs(value), scale):
        return "wide", f"the interval {low:.4g} to {high:.4g} is too wide for {value:.4g} to mean much"
    return "identified", ""
