"""Rivals: candidates fitted in the place of a cause, and whether the log rules them out.

A reader who expects one of them sees that it was tried, and how much less it explains.
"""

from collections.abc import Container, Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from ffgym.diagnosis.computing import FAILED
from ffgym.diagnosis.fit.fit import compute_explained, find_touched, loudness, subtract_nuisances
from ffgym.diagnosis.fit.hypothesis import Hypothesis, HypothesisKey
from ffgym.diagnosis.fit.problem import FitProblem
from ffgym.diagnosis.resampling import Pool, bootstrap
from ffgym.diagnosis.result import Rival, make_label
from ffgym.diagnosis.search.candidates import Candidates
from ffgym.diagnosis.search.ranking import Ranking
from ffgym.diagnosis.search.rounds import ScoredFit, SearchRound, find_adoption, fit_and_score
from ffgym.diagnosis.search.significance import compute_explained_by_newest
from ffgym.diagnosis.settings import settings

ALIKE_TEXT = "explains the log as well: these motions cannot tell both apart"


@dataclass(frozen=True, kw_only=True, eq=False)
class RivalComparison:
    """Causes beside what was fitted in the place of each of them."""

    rivals: tuple[Rival, ...]
    better: ScoredFit | None
    """All causes, with a rival in the place of one of them, if that leaves less on rows that were not used."""


def compare_rivals(
    problem: FitProblem, nominal: ScoredFit, fitted: ScoredFit, rounds: Sequence[SearchRound], rng: np.random.Generator
) -> RivalComparison:
    """Compare each cause that stayed with what was fitted in its place; what was adopted beside it is no rival."""
    # contests of each cause with what was fitted in its round
    found = []
    for one in rounds:
        stands = one.of(fitted.fit.hypotheses)
        if one.adopted and stands is not None:
            others = [other for other in one.tried if not other.hypothesis.is_among(fitted.fit.hypotheses)]
            found += [_contest(problem, nominal, fitted, one.before, stands, other, rng) for other in others]
    # a rival that is better takes the place; a wave is sure if nothing ties with it
    better = [one.instead for one in found if one.instead is not None and _is_better(one.instead, fitted, one.tied)]
    sure = {h.key for h in fitted.fit.hypotheses if not any(one.tied and one.best.repeats(h) for one in found)}
    return RivalComparison(
        rivals=tuple(one.rival(sure, fitted) for one in found),
        better=min(better, key=lambda tried: tried.rss, default=None),
    )


def _count_oddities(tried: ScoredFit) -> tuple[int, int]:
    """Count sizes that are not plausible, then effects: of explanations that tie, the one with fewer stands."""
    hypotheses = tried.fit.hypotheses
    return sum(h.implausible is not None for h in hypotheses), len({h.key for h in hypotheses})


def _describe_implausible(instead: ScoredFit, fitted: ScoredFit) -> str:
    """Describe a size that is not plausible beside a rival, but is with the cause."""
    known = {h.key for h in fitted.fit.hypotheses if h.implausible is not None}
    odd = (h for h in reversed(instead.fit.hypotheses) if h.implausible is not None and h.key not in known)
    own = next(odd)
    of = "" if own.repeats(instead.hypothesis) else f" of {own.label}"
    return f"{own.implausible}{of}"


def _is_better(instead: ScoredFit, fitted: ScoredFit, is_tied: bool) -> bool:
    now, then = _count_oddities(fitted), _count_oddities(instead)
    if _count_numbers(instead) > _count_numbers(fitted):
        return False
    return then < now if is_tied and then != now else instead.rss < fitted.rss


@dataclass(frozen=True, kw_only=True, eq=False)
class _Contest:
    """A cause, and what was fitted in its place."""

    best: Hypothesis
    other: Hypothesis
    gain: float
    tied: bool
    lost: str
    """Why it lost, unless it ties."""
    instead: ScoredFit | None
    """All causes with it in the place of the best, if they were fitted."""

    def rival(self, sure: Container[HypothesisKey], fitted: ScoredFit) -> Rival:
        """Report it as a rival; causes of the places `sure` have a wave with which nothing ties."""
        tied, reason = self.tied, ALIKE_TEXT if self.tied else self.lost
        if tied and self.best.key in sure:
            tied, reason = False, "explains this wave as well, and no other wave of the cause"
        elif tied and self.instead is not None and _count_oddities(self.instead)[0] > _count_oddities(fitted)[0]:
            tied, reason = False, f"explains as much, but would take a {_describe_implausible(self.instead, fitted)}"
        return Rival(
            effect=self.other.kind.name,
            joint=self.other.joint,
            held_out_gain=self.gain,
            tied=tied,
            against=self.best.label,
            reason=reason,
        )


def _contest(
    problem: FitProblem,
    nominal: ScoredFit,
    fitted: ScoredFit,
    before: ScoredFit,
    best: ScoredFit,
    other: ScoredFit,
    rng: np.random.Generator,
) -> _Contest:
    limits = settings().rivals
    # tie in the round in which the cause was adopted
    share = _compute_share(problem, before, best, other)
    others = [h for h in fitted.fit.hypotheses if not best.hypothesis.repeats(h)]
    tied, instead = share >= limits.instead and _is_tied(problem, before, best, other, rng), None
    # a close call is fitted again beside all other causes
    if best.hypothesis.kind.name in other.hypothesis.kind.generalises:
        tied = False  # it was fitted beside it, explains no more, and has more numbers
    elif others and (tied or share >= limits.near):  # what further causes explain may have hidden the difference
        with suppress(*FAILED):  # no machine may be able to be so
            instead = fit_and_score(problem, (*others, other.hypothesis), fitted.fit)
        tied = instead is not None and _is_tied(problem, nominal, fitted, instead, rng)
    elif tied and len(other.fit.hypotheses) == 1:
        instead = other
    # reason in words why the rival lost
    lost = f"leaves {other.rss / best.rss:.3g} times the energy on rows that were not used"
    if share < limits.instead:
        lost = f"explains little of what {best.hypothesis.label} does"
    return _Contest(
        best=best.hypothesis,
        other=other.hypothesis,
        gain=compute_explained_by_newest(problem, before, other).of_excess,
        tied=tied,
        lost=lost,
        instead=instead,
    )


def _compute_share(problem: FitProblem, before: ScoredFit, best: ScoredFit, other: ScoredFit) -> float:
    """Compute what a rival explains where the best acts, as a share of what the best explains there."""
    loud, by_best, by_other = (loudness(problem, subtract_nuisances(problem, one.fit)) for one in (before, best, other))
    where = find_touched(problem, list(best.fit.columns[-len(best.hypothesis.list_free()) :]))
    gone = compute_explained(loud, by_best, where).of_excess
    return compute_explained(loud, by_other, where).of_excess / max(gone, 1e-9)


def _is_tied(
    problem: FitProblem, before: ScoredFit, best: ScoredFit, other: ScoredFit, rng: np.random.Generator
) -> bool:
    """Tell whether another explanation is as good, by resampled blocks or within what inexact equations leave."""
    # resamples of what it leaves more in each block
    limits = settings().rivals
    more = other.rss_by_block - best.rss_by_block
    resampled = bootstrap(lambda counts: np.atleast_1d(counts @ more), Pool(len(more)), rng, limits.resamples)
    if np.quantile(resampled, limits.tied) <= 0:
        return True
    allowed = limits.alike * (before.rss - best.rss)
    if _count_numbers(other) == _count_numbers(best):
        allowed = min(allowed, _compute_inexactness(problem, best))
    return bool(_count_numbers(other) <= _count_numbers(best) and other.rss - best.rss <= allowed)


def _compute_inexactness(problem: FitProblem, best: ScoredFit) -> float:
    """Compute the energy above noise that an explanation leaves where its causes act, or that the floor leaves open."""
    loud, total = loudness(problem, subtract_nuisances(problem, best.fit)), 0.0
    for key in find_touched(problem, list(best.fit.columns)):
        rows = np.count_nonzero(np.broadcast_to(problem.weights[key], problem.blocks.of_row.shape))
        total += max(loud[key] - 1.0, settings().rivals.unsure_floor) * rows
    return total


def _count_numbers(tried: ScoredFit) -> int:
    """Count the numbers that were fitted."""
    return sum(len(hypothesis.list_free()) for hypothesis in tried.fit.hypotheses)


def select_tied(hypotheses: Sequence[Hypothesis], rivals: Sequence[Rival]) -> list[Hypothesis]:
    """Select hypotheses with which a rival ties."""
    against = {rival.against for rival in rivals if rival.tied}
    return [hypothesis for hypothesis in hypotheses if hypothesis.label in against]


def turn_into_rivals(
    unsure: Sequence[Hypothesis], rivals: Sequence[Rival], rounds: Sequence[SearchRound]
) -> tuple[Rival, ...]:
    """Turn causes that were dropped because a rival ties with them into rivals of that one."""
    against = {rival.against: make_label(rival.effect, rival.joint) for rival in rivals if rival.tied}
    found = []
    for one in unsure:
        then, tried = find_adoption(rounds, one)
        gain = 1.0 - tried.rss / then.before.rss  # share that it removed in the round in which it was found
        found.append(
            Rival(
                effect=one.kind.name,
                joint=one.joint,
                held_out_gain=gain,
                tied=True,
                against=against[one.label],
                reason=ALIKE_TEXT,
            )
        )
    return tuple(found)


def find_lookalikes(
    problem: FitProblem, candidates: Candidates, ranking: Ranking, before: ScoredFit, adopted: ScoredFit
) -> tuple[Rival, ...]:
    """Find rivals of a cause by the library's list of confusable effects, each with the best of its shapes."""
    # scores of effects of the list on the same joint
    cause, scores = adopted.hypothesis, dict[tuple[str, str], float]()
    for i in ranking.order.tolist():  # the best shape of an effect comes first
        column = candidates.first(candidates.groups[i])
        if column.effect.code in (cause.kind.code, *cause.kind.confusable_with) and column.joint in ("", cause.joint):
            scores.setdefault((column.effect.name, column.joint), max(0.0, float(ranking.score[i])))
    own = scores.pop((cause.kind.name, cause.joint), 0.0)
    if own <= 0:
        return ()
    gain = compute_explained_by_newest(problem, before, adopted).of_excess
    return tuple(
        Rival(
            effect=effect,
            joint=joint,
            held_out_gain=gain * score / own,
            tied=False,
            against=cause.label,
            reason=f"explains {score / own:.0%} of what {cause.label} does, on rows that were not used",
        )
        for (effect, joint), score in scores.items()
    )


def list_uncompared(rounds: tuple[SearchRound, ...], final: ScoredFit, rivals: tuple[Rival, ...]) -> tuple[Rival, ...]:
    """List lookalikes of the causes that were compared with nothing."""
    compared = {rival.against for rival in rivals}
    causes = {hypothesis.label for hypothesis in final.fit.hypotheses}
    names = {(hypothesis.kind.name, hypothesis.joint) for hypothesis in final.fit.hypotheses}
    return tuple(
        alike
        for one in rounds
        for alike in one.alike
        if alike.against in causes - compared and (alike.effect, alike.joint) not in names
    )
