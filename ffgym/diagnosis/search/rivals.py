"""Candidates that were fitted in the place of a cause: what they explain, and whether the log rules them out."""

from collections.abc import Sequence

import numpy as np

from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.fit.leftover import loudness, removed, touched, without_calibration
from ffgym.diagnosis.fit.refine import Setting
from ffgym.diagnosis.result import Rival
from ffgym.diagnosis.search.found import Round, Tried
from ffgym.diagnosis.search.judge import judged_with
from ffgym.diagnosis.search.worth import removed_by
from ffgym.types import Array

TIED = 0.05
"""A rival ties if it is at least as good in this share of resamples."""

ALIKE = 0.02
"""Share of what is above the noise by which a rival with no more numbers must explain less, whatever the resamples say:
no equation is exact, and one that is this near is not ruled out by what it leaves."""

INSTEAD = 0.5
"""Share of what a cause removes where it acts that a rival must remove there too; less explains something else."""

NEAR = 0.9
"""Share of what a cause removes where it acts from which on a rival that lost is compared once more beside the other
causes: without them it may have been led astray."""

RESAMPLES = 500

_ALIKE_TEXT = "explains the log as well: these motions cannot tell both apart"


def rivals_of(
    setting: Setting, nominal: Tried, fitted: Tried, rounds: Sequence[Round], rng: np.random.Generator
) -> tuple[Rival, ...]:
    """What was fitted in the place of each cause that stayed; what was adopted beside it is no rival.

    Args:
        setting: the log.
        nominal: the model without causes.
        fitted: with all of them.
        rounds: in which they were found.
        rng: resamples blocks.
    """
    stayed = {hypothesis.place for hypothesis in fitted.fit.hypotheses}
    return tuple(
        _rival(setting, nominal, fitted, one, other, rng)
        for one in rounds
        if one.adopted and one.tried[0].hypothesis.place in stayed
        for other in one.tried[1:]
        if other.hypothesis.place not in stayed
    )


def tied_among(hypotheses: Sequence[Hypothesis], rivals: Sequence[Rival]) -> list[Hypothesis]:
    """Hypotheses that a rival cannot be told from."""
    against = {rival.against for rival in rivals if rival.tied}
    return [hypothesis for hypothesis in hypotheses if hypothesis.label in against]


def as_rivals(unsure: Sequence[Hypothesis], rivals: Sequence[Rival], rounds: Sequence[Round]) -> tuple[Rival, ...]:
    """Causes that were dropped because a rival cannot be told from them, as rivals of that one."""
    gains = {rival.against: rival for rival in rivals if rival.tied}
    return tuple(
        Rival(
            effect=one.kind.name,
            joint=one.joint,
            held_out_gain=_gain(one, rounds),
            tied=True,
            against=_label(gains[one.label]),
            reason=_ALIKE_TEXT,
        )
        for one in unsure
    )


def _gain(hypothesis: Hypothesis, rounds: Sequence[Round]) -> float:
    (one,) = [one for one in rounds if one.adopted and one.tried[0].hypothesis.place == hypothesis.place][:1]
    return 1.0 - one.tried[0].total / one.before.total


def _label(rival: Rival) -> str:
    return f"{rival.effect} on {rival.joint}" if rival.joint else rival.effect


def _rival(
    setting: Setting, nominal: Tried, fitted: Tried, one: Round, other: Tried, rng: np.random.Generator
) -> Rival:
    before, best = one.before, one.tried[0]
    share, is_beside_others = _share(setting, before, best, other), len(fitted.fit.hypotheses) > 1
    tied = share >= INSTEAD and _is_tied(before, best, other, rng)
    if best.hypothesis.kind.name in other.hypothesis.kind.generalises:
        tied = False  # it was fitted beside it, explains no more, and has more numbers
    elif is_beside_others and (tied or share >= NEAR):  # what further causes explain may have hidden the difference
        others = [h for h in fitted.fit.hypotheses if h.place != best.hypothesis.place]
        tied = _is_tied(nominal, fitted, judged_with(setting, (*others, other.hypothesis)), rng)
    reason = f"leaves {other.total / best.total:.3g} times the energy on rows that were not used"
    if share < INSTEAD:
        reason = f"explains little of what {best.hypothesis.label} does"
    return Rival(
        effect=other.hypothesis.kind.name,
        joint=other.hypothesis.joint,
        held_out_gain=removed_by(setting, before, other).of_excess,
        tied=tied,
        against=best.hypothesis.label,
        reason=_ALIKE_TEXT if tied else reason,
    )


def _share(setting: Setting, before: Tried, best: Tried, other: Tried) -> float:
    """What a rival removes where the best acts, as a share of what that removes there."""
    loud, by_best, by_other = (
        loudness(setting, without_calibration(setting, one.fit)) for one in (before, best, other)
    )
    where = touched(setting, list(best.fit.columns[-len(best.hypothesis.free()) :]))
    gone = removed(loud, by_best, where).of_excess
    return removed(loud, by_other, where).of_excess / max(gone, 1e-9)


def _is_tied(before: Tried, best: Tried, other: Tried, rng: np.random.Generator) -> bool:
    """Whether another explanation is as good, by resamples or as good as an inexact equation can tell."""
    is_simpler = _numbers(other) <= _numbers(best)
    is_near = other.total - best.total <= ALIKE * (before.total - best.total)
    return _ties(best.left, other.left, rng) or (is_simpler and is_near)


def _numbers(tried: Tried) -> int:
    """Numbers that were fitted."""
    return sum(len(hypothesis.free()) for hypothesis in tried.fit.hypotheses)


def _ties(best: Array, other: Array, rng: np.random.Generator) -> bool:
    """Whether `other` may be as good: resamples of what it leaves more in each block."""
    more = other - best
    picks = rng.integers(len(more), size=(RESAMPLES, len(more)))
    return bool(np.quantile(more[picks].sum(axis=1), TIED) <= 0)
