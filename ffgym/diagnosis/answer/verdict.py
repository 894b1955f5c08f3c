"""The verdict: how much causes explain, what ties with them, and what is left."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ffgym.diagnosis.residual import Channel
from ffgym.diagnosis.result import Rival, Verdict
from ffgym.diagnosis.search.search import Found, Tried
from ffgym.types import Array

NAMED = 0.9
"""Share of the energy above the noise that causes must remove to be named without reserve..."""

QUIET = 2.0
"""...or what they may leave in every component, in units of the noise's energy."""

LOUD = 1.5
"""Energy from which on a component has something in it that noise does not explain."""

TIED = 0.05
"""A rival ties if it is at least as good in this share of resamples."""

RESAMPLES = 500

Loudness = Mapping[tuple[Channel, int], float]


@dataclass(frozen=True, kw_only=True, eq=False)
class Judged:
    """Verdict with its reasons in numbers."""

    verdict: Verdict
    gains: tuple[float, ...]
    """Of each cause: share of the energy above the noise that it removes from what was left out."""
    removed: float
    """Share that all causes remove together."""
    rivals: tuple[Rival, ...]


def judged(found: Found, loud_before: Loudness, loud_after: Loudness, rng: np.random.Generator) -> Judged:
    """What a search comes to."""
    above = max(found.nominal.total - found.rows, 1e-9)
    removed = (found.nominal.total - found.final.total) / above
    gains = _gains(found)
    rivals = _rivals(found, rng)
    worst = max(loud_after.values())
    verdict: Verdict
    if not found.final.fit.hypotheses:
        verdict = "unknown" if worst > LOUD else "none"
    elif any(rival.tied for rival in rivals):
        verdict = "ambiguous"
    elif removed >= NAMED or worst <= QUIET:
        verdict = "named"
    else:
        verdict = "partly"
    return Judged(verdict=verdict, gains=gains, removed=float(removed), rivals=rivals)


def _gains(found: Found) -> tuple[float, ...]:
    """Share that each cause removed of the energy above the noise that was there when it was adopted."""
    by_place: dict[tuple[str, str, int | None], float] = {}
    for one in found.rounds:
        if one.adopted:
            best = one.tried[0]
            above = max(one.before.total - found.rows, 1e-9)
            by_place[best.hypothesis.place] = float((one.before.total - best.total) / above)
    return tuple(by_place.get(h.place, 0.0) for h in found.final.fit.hypotheses)


def _rivals(found: Found, rng: np.random.Generator) -> tuple[Rival, ...]:
    """Candidates that were fitted in the place of a cause that stayed."""
    stayed = {hypothesis.place for hypothesis in found.final.fit.hypotheses}
    listed: list[Rival] = []
    for one in found.rounds:
        if one.adopted and one.tried[0].hypothesis.place in stayed:
            best = one.tried[0]
            listed += [_rival(one.before, best, other, found.rows, rng) for other in one.tried[1:]]
    return tuple(listed)


def _rival(before: Tried, best: Tried, other: Tried, rows: float, rng: np.random.Generator) -> Rival:
    above = max(before.total - rows, 1e-9)
    tied = _ties(best.left, other.left, rng)
    gain = float((before.total - other.total) / above)
    reason = (
        "explains the log as well: these motions cannot tell both apart"
        if tied
        else f"leaves {other.total / best.total:.3g} times the energy on rows that were not used"
    )
    return Rival(
        effect=other.hypothesis.kind.name,
        joint=other.hypothesis.joint,
        held_out_gain=gain,
        tied=tied,
        against=best.hypothesis.kind.name,
        reason=reason,
    )


def _ties(best: Array, other: Array, rng: np.random.Generator) -> bool:
    """Whether `other` may be as good: resamples of what it leaves more in each block."""
    more = other - best
    picks = rng.integers(len(more), size=(RESAMPLES, len(more)))
    return bool(np.quantile(more[picks].sum(axis=1), TIED) <= 0)
