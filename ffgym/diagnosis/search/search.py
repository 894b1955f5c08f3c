"""The search: adopt what explains most, fit it by replaying, look again at what is left, drop what is not needed."""

from collections.abc import Callable, Container, Sequence
from dataclasses import replace

import numpy as np

from ffgym.diagnosis.computing import FAILED, trim_heap
from ffgym.diagnosis.evidence import Evidence, Values
from ffgym.diagnosis.fit.fit import Fit, left_by
from ffgym.diagnosis.fit.hypothesis import Hypothesis, Place, machine_with
from ffgym.diagnosis.fit.refine import corrected
from ffgym.diagnosis.fit.setting import Setting, values_of
from ffgym.diagnosis.search.candidates import Candidates
from ffgym.diagnosis.search.found import Found, Round, Tried, judged_with, refitted, scored, slimmed, without_needless
from ffgym.diagnosis.search.ranking import Component, Ranking, acts_on, overlap, ranked, start_of
from ffgym.diagnosis.search.rivals import as_rivals, compared, lookalikes, tied_among, without_rival
from ffgym.diagnosis.search.worth import explains_most, is_worth
from ffgym.diagnosis.settings import settings

_HALVINGS = 4
"""Times that a linear fit is halved until a machine can be so."""

Report = Callable[[str, float], None]
"""Told what is done, and the share of the search that is done."""


def search(
    setting: Setting,
    candidates: Callable[[Fit], Candidates],
    faultless: Values,
    rng: np.random.Generator,
    report: Report = lambda what, share: None,
    most: int = settings().search.most_causes,
) -> Found:
    """Find the effects that explain a log.

    Args:
        setting: the log.
        candidates: effects to try beside those of a fit; frequencies are looked for in what it leaves.
        faultless: residuals of faultless logs, (R, M, K) by component.
        rng: resamples blocks.
        report: told what is done.
        most: causes to be found, from 1 to MOST; each wave of one that repeats with an angle counts.
    """
    nominal = now = judged_with(setting, ())
    first = candidates(now.fit)
    rounds, needless = [_round(setting, first, faultless, nominal, now, (), report)], list[Hypothesis]()
    while (one := rounds[-1]).adopted:
        grown = refitted(setting, one.tried[0])
        now = without_needless(setting, grown)
        needless += [h for h in grown.fit.hypotheses if not h.is_among(now.fit.hypotheses)]
        if len(now.fit.hypotheses) >= most:
            break
        rounds.append(_round(setting, candidates(now.fit), faultless, nominal, now, needless, report))
    beside = compared(setting, nominal, now, rounds, rng)
    for _ in range(settings().search.exchanges):
        if beside.better is None:
            break
        now = without_needless(setting, refitted(setting, beside.better))
        beside = compared(setting, nominal, now, rounds, rng)
    rivals = beside.rivals
    unsure = tied_among(now.fit.hypotheses, rivals)
    sure = [hypothesis for hypothesis in now.fit.hypotheses if hypothesis not in unsure]
    if sure and unsure:
        rivals = (*rivals, *as_rivals(unsure, rivals, rounds))
    rivals = (*rivals, *without_rival(tuple(rounds), now, rivals))
    final = _final(setting, nominal, now, sure or now.fit.hypotheses, report)
    is_left_out = bool(sure and unsure and final.fit.hypotheses)
    rows = float(now.fit.evidence.rows.sum())
    return Found(
        nominal=nominal,
        candidates=first,
        final=final,
        whole=now if is_left_out else final,
        rounds=tuple(rounds),
        rivals=rivals,
        unsure=tuple(unsure) if is_left_out else (),
        rows=rows,
    )


def _final(setting: Setting, nominal: Tried, now: Tried, kept: Sequence[Hypothesis], report: Report) -> Tried:
    """The model with those causes that are kept; the nominal one if all together explain too little.

    What a cause explains that ties with a rival is explained by one of both, whoever it is. A cause of which nothing is
    left once all of it is fitted together is none.
    """
    if not kept or not explains_most(setting, nominal, now):
        return nominal
    report("fitting all of it once more", 1.0)
    model = now if len(kept) == len(now.fit.hypotheses) else judged_with(setting, kept)
    fitted = scored(setting, corrected(setting, model.fit))
    there = [hypothesis for hypothesis in fitted.fit.hypotheses if not hypothesis.is_null]
    return fitted if len(there) == len(fitted.fit.hypotheses) else _final(setting, nominal, now, there, report)


def _round(
    setting: Setting,
    candidates: Candidates,
    faultless: Values,
    nominal: Tried,
    now: Tried,
    needless: Sequence[Hypothesis],
    report: Report,
) -> Round:
    """Rank, fit the best, and see whether the best of those is to be adopted; if not, look at other joints."""
    residual = values_of(now.fit.residual)
    together = {key: np.concatenate([rows, faultless[key]], axis=2) for key, rows in residual.items()}
    evidence = candidates.stack.evidence(together)
    ranking = ranked(evidence, candidates, candidates.calibration, with_most=now is nominal)
    chance = ranking.threshold * float(evidence.rows.sum()) / evidence.n_components
    done, beaten = Round(before=now, ranking=ranking, tried=(), adopted=False), set[str]()
    for _ in range(1 + settings().search.elsewhere):
        tried = _tried(setting, candidates, ranking, evidence, now, needless, beaten, report)
        if not tried:
            break
        worthy = next((other for other in tried if is_worth(setting, nominal, now, other, chance)), None)
        first = [other for other in (worthy, *tried) if other is not None]
        one = replace(done, tried=tuple(dict.fromkeys(first)), adopted=worthy is not None)
        if worthy is not None:
            return replace(one, alike=lookalikes(setting, candidates, ranking, now, worthy))
        done = done if done.tried else one
        beaten |= {other.hypothesis.joint for other in tried}
    return done


def _tried(
    setting: Setting,
    candidates: Candidates,
    ranking: Ranking,
    evidence: Evidence,
    now: Tried,
    needless: Sequence[Hypothesis],
    beaten: Container[str],
    report: Report,
) -> list[Tried]:
    """The best candidate on joints where none was beaten, and its rivals, fitted beside the causes; the best first.

    What others once made up for is not tried again: it would come and go for ever.
    """
    limits = settings().search
    fixed, tried = now.fit.hypotheses, list[Tried]()
    places: set[Place] = set()
    best, where = 0.0, dict[Component, float]()
    for i in ranking.order:
        if len(tried) == limits.tried or not ranking.is_significant(i) or ranking.score[i] < limits.near_best * best:
            break
        if candidates.first(candidates.groups[i]).joint in beaten:
            continue
        here = acts_on(evidence, candidates, int(i), candidates.calibration)
        if where and overlap(where, here) < limits.same_target:
            continue
        linear = start_of(evidence, candidates, int(i), candidates.calibration, setting.log.robot)
        if linear.place in places or linear.is_among((*fixed, *needless)):
            continue
        start = _possible(setting, fixed, linear)
        if start is None:
            continue
        places.add(start.place)
        best, where = max(best, float(ranking.score[i])), where or here
        report(f"fitting {start.label}", len(tried) / limits.tried)
        trim_heap()
        try:
            tried.append(slimmed(setting, judged_with(setting, (*fixed, start), now.fit), now.fit))
        except FAILED:
            continue  # what cannot be computed loses

    def price(one: Tried) -> float:
        """Energy that is left, and what each number costs: a share of that, or of what is removed if that is less."""
        share = max(0.0, min(one.total, now.total - one.total))
        return one.total + limits.slack * len(one.hypothesis.free()) * share

    return sorted(tried, key=price)


def _possible(setting: Setting, others: Sequence[Hypothesis], start: Hypothesis) -> Hypothesis | None:
    """A hypothesis as large as a machine can have it, at most as it is; None if none can, however little of it.

    What pushes the arm away from its springs must be tried: the arm may not stay where it is.
    """
    for _ in range(_HALVINGS):
        can_be = machine_with(setting.nominal, (*others, start)) is not None
        if can_be and (start.kind.side != "link" or left_by(setting, (*others, start)) < np.inf):
            return start
        start = start.scaled(0.5)
    return None
