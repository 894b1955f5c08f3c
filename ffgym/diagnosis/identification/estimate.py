"""Estimates of parameters: value, interval, and the reason where the data do not tell it."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.diagnosis.settings import settings

Status = Literal["identified", "given", "wide", "at bound", "not excited", "not measured"]
"""identified: the value is the data's; given: by the caller; of the others the data do not tell the value: its interval
is wide, it lies at a bound, no motion excites it, or no sensor shows it. For them the value before stays."""


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
        """True if the value is the data's."""
        return self.status == "identified"


def judge_estimate(
    value: float, low: float, high: float, *, scale: float, excited: str, at_bound: bool = False
) -> tuple[Status, str]:
    """Judge an estimate by its interval; return its status and the reason.

    A parameter below `scale` does not matter; `excited` says what the motions lack to tell it, '' if nothing.
    """
    if excited:
        return "not excited", excited
    if at_bound:
        return "at bound", f"the fit ends at the bound {value:.4g} of its range"
    half = (high - low) / 2
    if not np.isfinite(half):
        raise FFGymError(f"The interval [{low}, {high}] of an estimate must be finite.")
    if half > settings().friction.wide * max(abs(value), scale):
        return "wide", f"the interval {low:.4g} to {high:.4g} is too wide for {value:.4g} to mean much"
    return "identified", ""
