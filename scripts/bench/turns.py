"""Rates measured in turns, so that a busy machine is as hard on one as on the other."""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

Rate = Callable[[], float]
"""Function that measures once and returns an amount of work per second."""

WIDE = 0.1
"""Distance of the quartiles of a ratio, in parts of its median, above which it is called wide."""


@dataclass(frozen=True)
class Ratio:
    """Ratio of two speeds, from pairs of measurements next to each other in time."""

    title: str
    """Names of both sides of the comparison."""
    rates: tuple[float, ...]
    """Rates of the measured side, one per turn."""
    against: tuple[float, ...]
    """Rates of the side that it is compared with."""
    unit: str
    wanted: float | None = None
    """The ratio that is wanted at least."""

    def quartiles(self) -> tuple[float, float, float]:
        """Lower quartile, median and upper quartile of the ratio."""
        low, median, high = np.quantile(np.divide(self.rates, self.against), [0.25, 0.5, 0.75]).tolist()
        return low, median, high

    @property
    def is_wide(self) -> bool:
        """Tell whether the machine was too busy to trust the median."""
        low, median, high = self.quartiles()
        return high - low > WIDE * median

    def as_dict(self) -> dict[str, object]:
        """Everything, for JSON."""
        return {
            "title": self.title,
            "unit": self.unit,
            "rates": self.rates,
            "against": self.against,
            "ratio_quartiles": self.quartiles(),
            "wanted": self.wanted,
            "wide": self.is_wide,
        }

    def __str__(self) -> str:
        low, median, high = self.quartiles()
        wanted = "" if self.wanted is None else f"   wanted {self.wanted:g} or more"
        return (
            f"{self.title:48} {np.median(self.rates):10.0f} {np.median(self.against):10.0f} {self.unit:12} "
            f"{median:6.2f} ({low:.2f} to {high:.2f}){wanted}{'   WIDE' if self.is_wide else ''}"
        )


@dataclass(frozen=True)
class Amount:
    """One number, e.g. of memory."""

    title: str
    value: float
    unit: str
    wanted: float | None = None
    """The most that is wanted."""

    def as_dict(self) -> dict[str, object]:
        """Everything, for JSON."""
        return {"title": self.title, "value": self.value, "unit": self.unit, "wanted": self.wanted}

    def __str__(self) -> str:
        wanted = "" if self.wanted is None else f"   wanted {self.wanted:g} or less"
        return f"{self.title:48} {self.value:10.2f} {self.unit}{wanted}"


def rate_of(
    amount: float,
    work: Callable[[], object],
    before: Callable[[], object] = lambda: None,
    clock: Callable[[], float] = time.perf_counter,
) -> Rate:
    """Function that works for once, after what comes before it, and returns the amount of work per second."""

    def rate() -> float:
        before()
        began = clock()
        work()
        return amount / (clock() - began)

    return rate


def take_turns(title: str, first: Rate, second: Rate, repeats: int, *, unit: str, wanted: float | None = None) -> Ratio:
    """Rates that `first` and `second` return, called in turns; each is called once before, to warm up."""
    first(), second()
    pairs = [(first(), second()) for _ in range(repeats)]
    return Ratio(title, tuple(a for a, _ in pairs), tuple(b for _, b in pairs), unit, wanted)
