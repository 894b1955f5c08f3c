"""The verdict: how much causes explain, what ties with them, and what is left."""

from dataclasses import dataclass

from ffgym.diagnosis.fit.fit import Fit
from ffgym.diagnosis.fit.leftover import Loudness, removed, touched
from ffgym.diagnosis.fit.setting import Setting
from ffgym.diagnosis.result import Verdict
from ffgym.diagnosis.search.found import Found, found_in
from ffgym.diagnosis.search.stretched import stretched
from ffgym.diagnosis.search.ties import tied_among
from ffgym.diagnosis.search.worth import QUIET, removed_by

NAMED = 0.9
"""Share of the energy above the noise that causes must remove in each component to be named without reserve, or leave
no more than QUIET."""

HALF = 0.5
"""Share of what was left, where it acts, that each cause must remove to be named without reserve."""

LOUD = 1.5
"""Energy from which on a component has something in it that noise does not explain."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Judged:
    """Verdict with its reasons in numbers."""

    verdict: Verdict
    gains: tuple[float, ...]
    """Of each cause: share of the energy above the noise that it removes from what was left out."""
    removed: float
    """Share that all causes remove together."""
    stretched: tuple[str, ...]
    """Shapes at the end of their plausible range, such as 'time of dwell_stiction on j5': they may stand for something
    else."""


def judged(setting: Setting, found: Found, loud_before: Loudness, loud_after: Loudness) -> Judged:
    """What a search comes to.

    Args:
        setting: the log.
        found: by the search.
        loud_before: energy of the nominal residual over that of noise, by component.
        loud_after: the same with the causes.
    """
    where = touched(setting, list(found.final.fit.columns))
    share = removed(loud_before, loud_after, where).of_excess if where else 0.0
    gains = _gains(setting, found)
    worst = max(value - setting.inexact(key) for key, value in loud_after.items())
    stretched = stretched_shapes(setting, found.final.fit)
    verdict: Verdict
    if not found.final.fit.hypotheses:
        verdict = "unknown" if worst > LOUD else "none"
    elif tied_among(found.final.fit.hypotheses, found.rivals):
        verdict = "ambiguous"
    elif _is_explained(loud_before, loud_after) and min(gains) >= HALF and not (stretched or found.unsure):
        verdict = "named"
    else:
        verdict = "partly"
    return Judged(verdict=verdict, gains=gains, removed=float(share), stretched=stretched)


def _is_explained(before: Loudness, after: Loudness) -> bool:
    """Whether no component is left with something that no cause explains."""
    return all(after[key] <= QUIET or before[key] - after[key] >= NAMED * (before[key] - 1.0) for key in after)


def stretched_shapes(setting: Setting, fit: Fit) -> tuple[str, ...]:
    """Shapes of causes that the fit has moved to the end of their plausible range, such as 'time of cogging on j1'."""
    return tuple(f"{name} of {hypothesis.label}" for hypothesis, name in stretched(setting, fit))


def _gains(setting: Setting, found: Found) -> tuple[float, ...]:
    """Share that each cause removed of the energy above the noise that was there when it was found."""
    causes = (found_in(found.rounds, hypothesis) for hypothesis in found.final.fit.hypotheses)
    return tuple(removed_by(setting, one.before, tried).of_excess for one, tried in causes)
