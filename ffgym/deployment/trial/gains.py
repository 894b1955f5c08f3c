"""Gain from pairs of errors, with interval and p-value; claims of several places are held to one level together.

Each pair gives the logarithm of error with over error without the correction, which does not hang on the size of the
error, and in which a gain of one half and a doubling are equally far from nothing. Within a pair the order was drawn by
a coin, so that whatever drifts adds to this ratio with a sign that is even chance:

- The p-value is that of the randomisation test, which throws the coins of the plan again: no distribution is assumed.
- The interval is Student's. Its t-ratio is not above that of normal errors where errors are symmetric about the gain
  but unequal, which the coins see to; over several programs the means are averaged (Welch, Satterthwaite).
- Claims are made by Holm's rule over all places and the whole. scipy has none of it, and it is three lines.

References:
    Edgington & Onghena (2007), Randomization Tests, 4th ed., Chapman & Hall.
    Benjamini (1983), Is the t test really conservative when the parent distribution is long-tailed?, Journal of the
    American Statistical Association 78, 645-654.
    Satterthwaite (1946), Biometrics Bulletin 2, 110-114. Holm (1979), Scandinavian Journal of Statistics 6, 65-70.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
import scipy

from ffgym.core.types import Array
from ffgym.deployment.trial.power import LEVEL

OVERALL = "all programs"
"""Name of the gain over all programs."""
_RESAMPLES = 9_999
"""Throws of the coins where all of them would be more; with them the p-value scatters by 2e-3 at 0.05."""

Claim = Literal["gain", "worse", "none", "too few"]


@dataclass(frozen=True, kw_only=True)
class Gain:
    """Gain at one place, or over all: the share of the error that the correction takes away; negative is worse."""

    name: str
    """Name of the program, or OVERALL."""
    pairs: int
    """Pairs that it rests on."""
    gain: float
    """1 less the geometric mean of the ratios of errors with and without; NaN without pairs."""
    low: float
    """Lower end of the 95 % interval; NaN with fewer than two pairs."""
    high: float
    """Upper end of it."""
    p: float
    """Probability that the coins alone make a difference as large; 1 without pairs."""
    p_adjusted: float
    """The same, held to account for all places at once (Holm)."""
    spread: float
    """Standard deviation of the logarithm of the ratio of a pair; NaN where it is not known."""
    without: float
    """Geometric mean of the errors without the correction, in the unit of the trial."""
    corrected: float
    """Geometric mean of the errors with it."""

    @property
    def claim(self) -> Claim:
        """Claim that may be made: both the p-value and the interval must exclude chance."""
        if not np.isfinite(self.low):
            return "too few"
        if self.p_adjusted > LEVEL or self.low <= 0.0 <= self.high:
            return "none"
        return "gain" if self.gain > 0 else "worse"


def estimate_gains(errors: Mapping[str, Array]) -> list[Gain]:
    """Estimate the gain of each program, and over all where there are several.

    Args:
        errors: errors of pairs by program, shape (n, 2): without and with the correction, > 0.
    """
    logs = {name: np.log(pairs) for name, pairs in errors.items()}
    ratios = {name: pairs[:, 1] - pairs[:, 0] for name, pairs in logs.items()}
    found = [_estimate(name, [ratios[name]], [logs[name]]) for name in errors]
    if len(errors) > 1:
        known = [name for name in errors if len(ratios[name]) > 1]
        found.append(_estimate(OVERALL, [ratios[name] for name in known], [logs[name] for name in known]))
    adjusted = adjust_by_holm([each.p for each in found])
    return [replace(each, p_adjusted=p) for each, p in zip(found, adjusted, strict=True)]


def adjust_by_holm(p: Sequence[float]) -> list[float]:
    """Adjust p-values of several claims, so that any false one among them is made with the probability of the level."""
    values, adjusted = np.asarray(p, dtype=np.float64), np.empty(len(p))
    order = np.argsort(values)
    adjusted[order] = np.minimum(1.0, np.maximum.accumulate(values[order] * np.arange(len(p), 0, -1)))
    return [float(each) for each in adjusted]


def _estimate(name: str, ratios: Sequence[Array], logs: Sequence[Array]) -> Gain:
    """Estimate the gain of one place, or the mean over several of equal weight, from (n,) each and logs (n, 2)."""
    count = sum(map(len, ratios))
    values: dict[str, Any] = dict.fromkeys(("gain", "low", "high", "spread", "without", "corrected"), np.nan)
    values |= {"p": 1.0, "p_adjusted": 1.0}
    if count:
        centre = float(np.mean([own.mean() for own in ratios]))
        without, corrected = np.exp(np.mean([own.mean(axis=0) for own in logs], axis=0))
        values |= {"gain": -float(np.expm1(centre)), "without": float(without), "corrected": float(corrected)}
        values["p"] = _throw_coins(ratios)
        if all(len(own) > 1 for own in ratios):
            reach = _reach(ratios)
            values |= {"low": -float(np.expm1(centre + reach)), "high": -float(np.expm1(centre - reach))}
            values["spread"] = float(np.sqrt(np.mean([own.var(ddof=1) for own in ratios])))
    return Gain(name=name, pairs=count, **values)


def _reach(ratios: Sequence[Array]) -> float:
    """Compute the half width of the 95 % interval of the mean over places; that of one place is the paired t-test's."""
    parts = np.array([own.var(ddof=1) / len(own) for own in ratios]) / len(ratios) ** 2
    if not parts.sum():
        return 0.0
    freedom = parts.sum() ** 2 / sum(
        part**2 / (len(own) - 1) for part, own in zip(parts, ratios, strict=True) if part > 0
    )
    return float(scipy.stats.t.ppf(1 - LEVEL / 2, freedom) * np.sqrt(parts.sum()))


def _throw_coins(ratios: Sequence[Array]) -> float:
    """Compute the p-value of the randomisation test: the coin of each pair is thrown again, of all where they are few.

    Programs count alike, however many pairs of each are left.
    """
    weighted = np.concatenate([own / len(own) for own in ratios])
    if len(weighted) < 2:  # of one coin, both sides are as rare
        return 1.0
    result = scipy.stats.permutation_test(
        (weighted,),
        lambda values, axis: values.sum(axis=axis),
        permutation_type="samples",
        vectorized=True,
        n_resamples=_RESAMPLES,
        random_state=np.random.default_rng(0),
    )
    return float(result.pvalue)
