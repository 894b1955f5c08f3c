"""The verdict: how much causes explain, what ties with them, and what is left."""

from dataclasses import dataclass

import numpy as np

from ffgym.diagnosis.fit.leftover import Loudness, removed, touched
from ffgym.diagnosis.fit.refine import Setting
from ffgym.diagnosis.result import Rival, Verdict
from ffgym.diagnosis.search.found import Found, Tried
from ffgym.diagnosis.search.worth import removed_by
from ffgym.types import Array

NAMED = 0.9
"""Share of the energy above the noise that causes must remove in each component to be named without reserve..."""

HALF = 0.5
"""Share of what was left, where it acts, that each cause must remove to be named without reserve."""

QUIET = 2.0
"""...or what they may leave there, in units of the noise's energy."""

LOUD = 1.5
"""Energy from which on a component has something in it that noise does not explain."""

TIED = 0.05
"""A rival ties if it is at least as good in this share of resamples."""

ALIKE = 0.02
"""Share of what is above the noise by which a rival with no more numbers must explain less, whatever the resamples say:
no equation is exact, and one that is this near is not ruled out by what it leaves."""

RESAMPLES = 500


@dataclass(frozen=True, kw_only=True, eq=False)
class Judged:
    """Verdict with its reasons in numbers."""

    verdict: Verdict
    gains: tuple[float, ...]
    """Of each cause: share of the energy above the noise that it removes from what was left out."""
    removed: float
    """Share that all causes remove together."""
    rivals: tuple[Rival, ...]


def judged(
    setting: Setting, found: Found, loud_before: Loudness, loud_after: Loudness, rng: np.random.Generator
) -> Judged:
    """What a search comes to.

    Args:
        setting: the log.
        found: by the search.
        loud_before: energy of the nominal residual over that of noise, by component.
        loud_after: the same with the causes.
        rng: resamples blocks.
    """
    where = touched(setting, list(found.final.fit.columns))
    share = removed(loud_before, loud_after, where).of_excess if where else 0.0
    gains = _gains(setting, found)
    rivals = _rivals(setting, found, rng)
    worst = max(loud_after.values())
    verdict: Verdict
    if not found.final.fit.hypotheses:
        verdict = "unknown" if worst > LOUD else "none"
    elif any(rival.tied for rival in rivals):
        verdict = "ambiguous"
    elif _is_explained(loud_before, loud_after) and min(gains) >= HALF:
        verdict = "named"
    else:
        verdict = "partly"
    return Judged(verdict=verdict, gains=gains, removed=float(share), rivals=rivals)


def _is_explained(before: Loudness, after: Loudness) -> bool:
    """Whether no component is left with something that no cause explains."""
    return all(after[key] <= QUIET or before[key] - after[key] >= NAMED * (before[key] - 1.0) for key in after)


def _gains(setting: Setting, found: Found) -> tuple[float, ...]:
    """Share that each cause removed of the energy above the noise that was there when it was adopted."""
    by_place: dict[tuple[str, str, int | None], list[float]] = {}
    for one in found.rounds:
        if one.adopted:  # several waves of one effect in the order in which they were found
            gains = by_place.setdefault(one.tried[0].hypothesis.place, [])
            gains.append(removed_by(setting, one.before, one.tried[0]).of_excess)
    return tuple(by_place[h.place].pop(0) for h in found.final.fit.hypotheses)


def _rivals(setting: Setting, found: Found, rng: np.random.Generator) -> tuple[Rival, ...]:
    """Candidates that were fitted in the place of a cause that stayed."""
    stayed = {hypothesis.place for hypothesis in found.final.fit.hypotheses}
    return tuple(
        _rival(setting, one.before, one.tried[0], other, rng)
        for one in found.rounds
        if one.adopted and one.tried[0].hypothesis.place in stayed
        for other in one.tried[1:]
    )


def _rival(setting: Setting, before: Tried, best: Tried, other: Tried, rng: np.random.Generator) -> Rival:
    gains = [removed_by(setting, before, one).of_excess for one in (best, other)]
    is_simpler = len(other.hypothesis.free()) <= len(best.hypothesis.free())
    tied = _ties(best.left, other.left, rng) or (is_simpler and gains[1] >= gains[0] - ALIKE)
    reason = (
        "explains the log as well: these motions cannot tell both apart"
        if tied
        else f"leaves {other.total / best.total:.3g} times the energy on rows that were not used"
    )
    return Rival(
        effect=other.hypothesis.kind.name,
        joint=other.hypothesis.joint,
        held_out_gain=gains[1],
        tied=tied,
        against=best.hypothesis.label,
        reason=reason,
    )


def _ties(best: Array, other: Array, rng: np.random.Generator) -> bool:
    """Whether `other` may be as good: resamples of what it leaves more in each block."""
    more = other - best
    picks = rng.integers(len(more), size=(RESAMPLES, len(more)))
    return bool(np.quantile(more[picks].sum(axis=1), TIED) <= 0)
