"""Number of pairs that shows a gain: power of the paired test, from a pilot's spread or a stated one.

statsmodels and pingouin have the power of a paired t-test, too, and nothing that a trial needs beside it; the
noncentral t-distribution of scipy is the whole of it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from ffgym.core.errors import FFGymError, check_number

LEVEL = 0.05
"""Probability of a claim where there is nothing to claim."""
POWER = 0.9
"""Default probability of showing a gain that is there."""
SPREAD = 0.05
"""Assumed spread where no pilot says better; chosen: between the 1 % of runs that repeat well and 10 %."""
LEAST_SPREAD = 1e-6
"""Smallest spread that is reckoned with; chosen, no two runs of a machine are as equal."""
MOST_PAIRS = 500
"""Largest number of pairs that is looked at."""
_CAUTION = 0.8
"""Confidence with which a pilot's spread is not larger than what is reckoned with.

Reference:
    Browne (1995), Statistics in Medicine 14, 1933-1940: on the use of a pilot sample for sample size determination.
"""


@dataclass(frozen=True, kw_only=True)
class Power:
    """Assumptions of a plan, and what follows for the number of its pairs."""

    gain: float
    """Gain that is to be shown, as a share of the error."""
    spread: float
    """Standard deviation of the logarithm of the ratio of both errors of a pair."""
    source: str
    """Words for where the spread comes from."""
    power: float
    """Probability of showing the gain that is wanted."""
    places: int
    """Programs that are judged side by side."""

    @property
    def needed(self) -> int | None:
        """Pairs of each program that are needed; None if they are more than MOST_PAIRS."""
        return count_pairs(self.gain, self.spread, power=self.power, places=self.places)


def compute_power(gain: float, spread: float, pairs: int, *, places: int = 1) -> float:
    """Compute the probability that a gain is shown at each of several places.

    Args:
        gain: share of the error that goes away, below 1.
        spread: standard deviation of the logarithm of the ratio of a pair.
        pairs: pairs of each program.
        places: programs that are judged side by side; claims of all of them and of the whole are held to LEVEL.
    """
    level = LEVEL / _claims(places)
    if pairs < 2 or 2.0 ** (1 - pairs) > level:  # fewer orders than the randomisation test could be sure by
        return 0.0
    centre = abs(np.log1p(-gain)) * np.sqrt(pairs) / spread
    limit = scipy.stats.t.ppf(1 - level / 2, pairs - 1)
    with np.errstate(all="ignore"):
        beyond = scipy.stats.nct.sf(limit, pairs - 1, centre)
    return float(beyond) if np.isfinite(beyond) else 1.0


def count_pairs(gain: float, spread: float, *, power: float = POWER, places: int = 1) -> int | None:
    """Count the pairs of each program that show a gain; None if more than MOST_PAIRS would be needed.

    Raises:
        FFGymError: if a number is out of range.
    """
    gain = check_number("gain", gain, low=0.0, high=0.99, open_low=True)
    spread = check_number("spread of the ratios of pairs", spread, low=LEAST_SPREAD, high=3.0)
    power = check_number("power", power, low=LEVEL, high=0.999)
    fits = (n for n in range(2, MOST_PAIRS + 1) if compute_power(gain, spread, n, places=places) >= power)
    return next(fits, None)


def count_least_pairs(places: int) -> int:
    """Count the pairs below which chance alone could explain any result, so that nothing can be shown at a place."""
    return int(np.ceil(1 + np.log2(_claims(places) / LEVEL)))


def find_least_gain(spread: float, pairs: int, *, power: float = POWER, places: int = 1) -> float | None:
    """Find the smallest gain that so many pairs show with that power; None if they show none."""
    if compute_power(0.999, spread, pairs, places=places) < power:
        return None
    return float(
        scipy.optimize.brentq(lambda gain: compute_power(gain, spread, pairs, places=places) - power, 1e-9, 0.999)
    )


def pool_pilot(spreads: Sequence[float], freedom: Sequence[int]) -> float:
    """Pool spreads of a pilot, each with its degrees of freedom, to the upper end of what they leave open.

    Raises:
        FFGymError: if the pilot has no pair to spare.
    """
    total = int(sum(freedom))
    if total < 1:
        raise FFGymError("The pilot has no program with two pairs or more, so that it tells no spread.")
    pooled = np.sqrt(np.dot(freedom, np.square(spreads)) / total)
    return float(pooled * np.sqrt(total / scipy.stats.chi2.ppf(1 - _CAUTION, total)))


def _claims(places: int) -> int:
    """Claims that are tested side by side: each place, and the whole where there are several."""
    return places + 1 if places > 1 else 1
