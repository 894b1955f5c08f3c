"""Search for causes by forward selection with pruning.

Each round adopts the candidate that explains most, fits it by replaying, and searches what is left; causes that the
others make up for are dropped. In the end each cause is compared with its rivals.
"""

from collections.abc import Callable, Container, Sequence
from dataclasses import replace

import numpy as np

from ffgym.diagnosis.computing import FAILED, trim_heap
from ffgym.diagnosis.fit.fit import Fit, compute_rss
from ffgym.diagnosis.fit.hypothesis import Hypothesis, HypothesisKey, build_machine
from ffgym.diagnosis.fit.problem import FitProblem, split_components
from ffgym.diagnosis.fit.refine import correct_bias
from ffgym.diagnosis.normal_equations import NormalEquations, Values
from ffgym.diagnosis.search.candidates import Candidates
from ffgym.diagnosis.search.ranking import (
    Component,
    Ranking,
    compute_overlap,
    find_changed_components,
    propose_start,
    rank,
)
from ffgym.diagnosis.search.rivals import (
    compare_rivals,
    find_lookalikes,
    list_uncompared,
    select_tied,
    turn_into_rivals,
)
from ffgym.diagnosis.search.rounds import (
    ScoredFit,
    SearchResult,
    SearchRound,
    drop_needless,
    fit_and_score,
    prune,
    refit,
    score,
)
from ffgym.diagnosis.search.significance import explains_most, is_significant
from ffgym.diagnosis.settings import settings

_HALVINGS = 4
"""Times that a linear fit is halved until a machine can be so."""

Report = Callable[[str, float], None]
"""Told what is done, and the share of the search that is done."""


def search(
    problem: FitProblem,
    candidates: Callable[[Fit], Candidates],
    null_residuals: Values,
    rng: np.random.Generator,
    report: Report = lambda what, share: None,
    most: int | None = None,
) -> SearchResult:
    """Find the effects that explain a log.

    Args:
        problem: the log.
        candidates: effects to try beside those of a fit; frequencies are looked for in what it leaves.
        null_residuals: residuals of faultless logs, (R, M, K) by component.
        rng: resamples blocks.
        report: told what is done.
        most: causes to be found at most, None for the setting; each wave of one that repeats with an angle counts.
    """
    # rounds: adopt a cause, refit all, drop those that the others make up for
    most = settings().search.most_causes if most is None else most
    nominal = now = fit_and_score(problem, ())
    first = candidates(now.fit)
    rounds, needless = [_run_round(problem, first, null_residuals, nominal, now, (), report)], list[Hypothesis]()
    while (one := rounds[-1]).adopted:
        grown = refit(problem, one.tried[0])
        now = drop_needless(problem, grown)
        needless += [h for h in grown.fit.hypotheses if not h.is_among(now.fit.hypotheses)]
        if len(now.fit.hypotheses) >= most:
            break
        rounds.append(_run_round(problem, candidates(now.fit), null_residuals, nominal, now, needless, report))
    # exchange causes for rivals that explain more
    beside = compare_rivals(problem, nominal, now, rounds, rng)
    for _ in range(settings().search.exchanges):
        if beside.better is None:
            break
        now = drop_needless(problem, refit(problem, beside.better))
        beside = compare_rivals(problem, nominal, now, rounds, rng)
    # causes that tie with a rival are unsure, and are left out beside sure ones
    rivals = beside.rivals
    unsure = select_tied(now.fit.hypotheses, rivals)
    sure = [hypothesis for hypothesis in now.fit.hypotheses if hypothesis not in unsure]
    if sure and unsure:
        rivals = (*rivals, *turn_into_rivals(unsure, rivals, rounds))
    rivals = (*rivals, *list_uncompared(tuple(rounds), now, rivals))
    # final fit of the sure causes alone, or of all causes where none is sure
    final = _conclude(problem, nominal, now, sure or now.fit.hypotheses, report)
    is_left_out = bool(sure and unsure and final.fit.hypotheses)
    rows = float(now.fit.equations.rows.sum())
    return SearchResult(
        nominal=nominal,
        candidates=first,
        final=final,
        whole=now if is_left_out else final,
        rounds=tuple(rounds),
        rivals=rivals,
        unsure=tuple(unsure) if is_left_out else (),
        rows=rows,
    )


def _conclude(
    problem: FitProblem, nominal: ScoredFit, now: ScoredFit, kept: Sequence[Hypothesis], report: Report
) -> ScoredFit:
    """Choose the final model: that with the causes that are kept, or the nominal one if all explain too little.

    What a cause explains that ties with a rival is explained by one of both, whoever it is. A cause of which nothing is
    left once all of it is fitted together is none.
    """
    if not kept or not explains_most(problem, nominal, now):
        return nominal
    report("fitting all of it once more", 1.0)
    model = now if len(kept) == len(now.fit.hypotheses) else fit_and_score(problem, kept)
    fitted = score(problem, correct_bias(problem, model.fit))
    there = [hypothesis for hypothesis in fitted.fit.hypotheses if not hypothesis.is_null]
    return fitted if len(there) == len(fitted.fit.hypotheses) else _conclude(problem, nominal, now, there, report)


def _run_round(
    problem: FitProblem,
    candidates: Candidates,
    null_residuals: Values,
    nominal: ScoredFit,
    now: ScoredFit,
    needless: Sequence[Hypothesis],
    report: Report,
) -> SearchRound:
    """Rank candidates, fit the best, and adopt the first significant one; if there is none, go on to other joints."""
    # score all candidates on the residual of the log and on surrogates
    residual = split_components(now.fit.residual)
    together = {key: np.concatenate([rows, null_residuals[key]], axis=2) for key, rows in residual.items()}
    equations = candidates.design.form_equations(together)
    ranking = rank(equations, candidates, candidates.nuisance_places, with_most=now is nominal)
    chance = ranking.threshold * float(equations.rows.sum()) / equations.n_components
    # fit the best; if none is significant, go on with other joints
    done, beaten = SearchRound(before=now, ranking=ranking, tried=(), adopted=False), set[str]()
    for _ in range(1 + settings().search.elsewhere):
        tried = _fit_best(problem, candidates, ranking, equations, now, needless, beaten, report)
        if not tried:
            break
        worthy = next((other for other in tried if is_significant(problem, nominal, now, other, chance)), None)
        first = [other for other in (worthy, *tried) if other is not None]
        one = replace(done, tried=tuple(dict.fromkeys(first)), adopted=worthy is not None)
        if worthy is not None:
            return replace(one, alike=find_lookalikes(problem, candidates, ranking, now, worthy))
        done = done if done.tried else one
        beaten |= {other.hypothesis.joint for other in tried}
    return done


def _fit_best(
    problem: FitProblem,
    candidates: Candidates,
    ranking: Ranking,
    equations: NormalEquations,
    now: ScoredFit,
    needless: Sequence[Hypothesis],
    beaten: Container[str],
    report: Report,
) -> list[ScoredFit]:
    """Fit the best candidate on joints where none was beaten, and its rivals, beside the causes; the best first.

    What others once made up for is not tried again: it would come and go for ever.
    """
    limits = settings().search
    fixed, tried = now.fit.hypotheses, list[ScoredFit]()
    places: set[HypothesisKey] = set()
    best, where = 0.0, dict[Component, float]()
    # walk down the ranking: significant, near the best, and an explanation of the same components
    for i in ranking.order:
        if len(tried) == limits.tried or not ranking.is_significant(i) or ranking.score[i] < limits.near_best * best:
            break
        if candidates.first(candidates.groups[i]).joint in beaten:
            continue
        here = find_changed_components(equations, candidates, int(i), candidates.nuisance_places)
        if where and compute_overlap(where, here) < limits.same_target:
            continue
        # begin at the linear fit, as large as a machine can have it
        linear = propose_start(equations, candidates, int(i), candidates.nuisance_places, problem.log.robot)
        if linear.key in places or linear.is_among((*fixed, *needless)):
            continue
        start = _shrink_to_possible(problem, fixed, linear)
        if start is None:
            continue
        # fit by replaying, and prune sizes that are not needed
        places.add(start.key)
        best, where = max(best, float(ranking.score[i])), where or here
        report(f"fitting {start.label}", len(tried) / limits.tried)
        trim_heap()
        try:
            tried.append(prune(problem, fit_and_score(problem, (*fixed, start), now.fit), now.fit))
        except FAILED:
            continue  # what cannot be computed loses

    def price(one: ScoredFit) -> float:
        """Compute the energy left and a price of each number: a share of that, or of what is explained if less."""
        share = max(0.0, min(one.rss, now.rss - one.rss))
        return one.rss + limits.slack * len(one.hypothesis.list_free()) * share

    return sorted(tried, key=price)


def _shrink_to_possible(problem: FitProblem, others: Sequence[Hypothesis], start: Hypothesis) -> Hypothesis | None:
    """Shrink a hypothesis until a machine can have it; None if no machine can, however small it is.

    What pushes the arm away from its springs must be tried: the arm may not stay where it is.
    """
    for _ in range(_HALVINGS):
        can_be = build_machine(problem.nominal, (*others, start)) is not None
        if can_be and (start.kind.side != "link" or compute_rss(problem, (*others, start)) < np.inf):
            return start
        start = start.scale(0.5)
    return None
