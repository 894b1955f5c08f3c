"""The search: adopt what explains most, fit it by replaying, look again at what is left, drop what is not needed."""

from collections.abc import Callable, Container, Sequence
from dataclasses import replace

import numpy as np

from ffgym.diagnosis.evidence.folds import half_folds, motion_folds
from ffgym.diagnosis.evidence.screen import left_by_block
from ffgym.diagnosis.evidence.stack import Evidence, Values
from ffgym.diagnosis.fit.corrected import corrected
from ffgym.diagnosis.fit.hypothesis import Hypothesis, machine_with
from ffgym.diagnosis.fit.refine import Fit, Setting, evaluated, fit, polished, values_of
from ffgym.diagnosis.search.candidates import Candidates
from ffgym.diagnosis.search.found import Found, Round, Tried
from ffgym.diagnosis.search.ranking import Ranking, ranked, start_of
from ffgym.diagnosis.search.worth import explains_most, is_worth

MOST = 4
"""Causes that are named at most; a model that lacks more is better identified anew."""

TRIED = 3
"""Candidates that are fitted by replaying, in each round."""

NEAR = 0.5
"""Share of the best candidate's score from which on another is fitted, too."""

ELSEWHERE = 2
"""Times that a round goes on with candidates of other joints, where the best is not adopted."""

NEEDED = 0.05
"""Share of the energy that a cause must keep away beside the others, else it is dropped."""

QUIET = 1.05
"""Energy left, in units of the noise's, from which on a fit may gain from being finer."""

_HALVINGS = 4
"""Times that a linear fit is halved until a machine can be so."""

SLACK = 0.02
"""Share of the energy by which a hypothesis with more numbers must beat one with fewer."""

Report = Callable[[str, float], None]
"""Told what is done, and the share of the search that is done."""


def search(
    setting: Setting,
    candidates: Callable[[Fit], Candidates],
    faultless: Values,
    report: Report = lambda what, share: None,
) -> Found:
    """Find the effects that explain a log.

    Args:
        setting: the log.
        candidates: effects to try beside those of a fit; frequencies are looked for in what it leaves.
        faultless: residuals of faultless logs, (R, M, K) by component.
        report: told what is done.
    """
    nominal = now = judged_with(setting, ())
    rounds: list[Round] = []
    while len(now.fit.hypotheses) < MOST:
        one = _round(setting, candidates(now.fit), faultless, nominal, now, report)
        rounds.append(one)
        if not one.adopted:
            break
        now = _without_needless(setting, _polished(setting, one.tried[0]))
    final = nominal
    if now.fit.hypotheses and explains_most(setting, nominal, now):
        report("fitting all of it once more", 1.0)
        final = _scored(setting, corrected(setting, now.fit))
    rows = float(now.fit.evidence.rows.sum())
    return Found(nominal=nominal, fitted=now, final=final, rounds=tuple(rounds), rows=rows)


def _round(
    setting: Setting, candidates: Candidates, faultless: Values, nominal: Tried, now: Tried, report: Report
) -> Round:
    """Rank, fit the best, and see whether the best of those is to be adopted; if not, look at other joints."""
    residual = values_of(now.fit.residual)
    together = {key: np.concatenate([rows, faultless[key]], axis=2) for key, rows in residual.items()}
    evidence = candidates.stack.evidence(together)
    ranking = ranked(evidence, candidates, candidates.calibration)
    done, beaten = Round(before=now, candidates=candidates, ranking=ranking, tried=(), adopted=False), set[str]()
    for _ in range(1 + ELSEWHERE):
        tried = _tried(setting, candidates, ranking, evidence, now, beaten, report)
        if not tried:
            break
        one = replace(done, tried=tuple(tried), adopted=is_worth(setting, nominal, now, tried[0]))
        if one.adopted:
            return one
        done = done if done.tried else one
        beaten |= {other.hypothesis.joint for other in tried}
    return done


def _tried(
    setting: Setting,
    candidates: Candidates,
    ranking: Ranking,
    evidence: Evidence,
    now: Tried,
    beaten: Container[str],
    report: Report,
) -> list[Tried]:
    """The best candidates that are not on joints where others were beaten, fitted beside the causes; the best first."""
    fixed, tried = now.fit.hypotheses, list[Tried]()
    places: set[tuple[str, str, int | None]] = set()
    best = 0.0
    for i in ranking.order:
        if len(tried) == TRIED or not ranking.is_significant(i) or ranking.score[i] < NEAR * best:
            break
        if candidates.first(candidates.groups[i]).joint in beaten:
            continue
        linear = start_of(evidence, candidates, int(i), candidates.calibration, setting.log.robot)
        start = _possible(setting, fixed, linear)
        if start is None or start.place in places or any(start.repeats(known) for known in fixed):
            continue
        places.add(start.place)
        best = max(best, float(ranking.score[i]))
        report(f"fitting {start.label}", len(tried) / TRIED)
        tried.append(judged_with(setting, (*fixed, start)))
    return sorted(tried, key=lambda one: one.total * (1 + SLACK * len(one.hypothesis.free())))


def _possible(setting: Setting, others: Sequence[Hypothesis], start: Hypothesis) -> Hypothesis | None:
    """A hypothesis as large as a machine can have it, at most as it is; None if none can, however little of it."""
    for _ in range(_HALVINGS):
        if machine_with(setting.nominal, (*others, start)) is not None:
            return start
        start = start.scaled(0.5)
    return None


def _polished(setting: Setting, adopted: Tried) -> Tried:
    """The adopted cause, fitted more finely if there is anything left to explain."""
    if adopted.fit.left < QUIET * float(adopted.fit.evidence.rows.sum()):
        return adopted
    finer = polished(setting, adopted.fit)
    return adopted if finer is adopted.fit else _scored(setting, finer)


def judged_with(setting: Setting, hypotheses: Sequence[Hypothesis]) -> Tried:
    """Fit, then judge by blocks that were left out."""
    return _scored(setting, fit(setting, hypotheses) if hypotheses else evaluated(setting, ()))


def _scored(setting: Setting, found: Fit) -> Tried:
    """A fit with what it leaves in blocks that were left out."""
    halves, motions = half_folds(setting.blocks), motion_folds(setting.blocks)
    left = [
        left_by_block(found.evidence, folds, found.everything, found.priors) for folds in (halves, motions) if folds
    ]
    return Tried(fit=found, left=np.mean(left, axis=0))


def _without_needless(setting: Setting, now: Tried) -> Tried:
    """Drop causes that the others make up for."""
    for i in range(len(now.fit.hypotheses) - 1):
        others = [h for k, h in enumerate(now.fit.hypotheses) if k != i]
        if machine_with(setting.nominal, others) is None:
            continue
        fewer = judged_with(setting, others)
        if fewer.total <= now.total * (1 + NEEDED):
            return _without_needless(setting, fewer)
    return now
