"""Rounds of a search: fits that are scored by held-out blocks, pruned, refitted, kept or dropped.

Friction that depends on temperature has three sizes, of Coulomb, breakaway and viscous torque. Where one of them is in
the log, the other two bend around noise, and lose against another effect of a single size that looks alike.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.computing import FAILED
from ffgym.diagnosis.fit.fit import Fit, evaluate, renew_tangents
from ffgym.diagnosis.fit.hypothesis import Hypothesis, build_machine
from ffgym.diagnosis.fit.problem import FitProblem
from ffgym.diagnosis.fit.refine import fit, polish, refine
from ffgym.diagnosis.resampling import make_half_folds, make_motion_folds
from ffgym.diagnosis.result import Rival
from ffgym.diagnosis.search.candidates import Candidates
from ffgym.diagnosis.search.ranking import Ranking
from ffgym.diagnosis.settings import settings
from ffgym.diagnosis.solving import Priors, compute_block_rss


@dataclass(frozen=True, kw_only=True, eq=False)
class ScoredFit:
    """Fit of a candidate with its score on held-out blocks."""

    fit: Fit
    rss_by_block: Array
    """Energy left in each block by fits to others, both splits in mean, shape (B,)."""

    @property
    def hypothesis(self) -> Hypothesis:
        """Newest hypothesis, which was tried."""
        return self.fit.hypotheses[-1]

    @property
    def rss(self) -> float:
        """Energy left in all blocks."""
        return float(self.rss_by_block.sum())


@dataclass(frozen=True, kw_only=True, eq=False)
class SearchRound:
    """One round of the search: candidates by score, and those that were fitted, best first."""

    before: ScoredFit
    ranking: Ranking
    tried: tuple[ScoredFit, ...]
    adopted: bool
    alike: tuple[Rival, ...] = ()
    """Effects that are easily taken for what was adopted, by their scores."""

    def of(self, hypotheses: Iterable[Hypothesis]) -> ScoredFit | None:
        """Return the first fit of one of some hypotheses, whatever their values; None if none was tried."""
        known = tuple(hypotheses)
        return next((tried for tried in self.tried if tried.hypothesis.is_among(known)), None)


def find_adoption(rounds: Iterable[SearchRound], hypothesis: Hypothesis) -> tuple[SearchRound, ScoredFit]:
    """Find the round in which a cause was adopted, and its fit there; for a wave that moved far, one of its effect."""
    tried = [(one, other) for one in rounds if one.adopted for other in one.tried]
    of_effect = [pair for pair in tried if pair[1].hypothesis.key == hypothesis.key]
    return next((pair for pair in of_effect if pair[1].hypothesis.repeats(hypothesis)), of_effect[0])


@dataclass(frozen=True, kw_only=True, eq=False)
class SearchResult:
    """Result of a search: models, rounds, rivals and ties."""

    nominal: ScoredFit
    candidates: Candidates
    """Candidates of the first round; those of later ones take much memory, and are not needed."""
    final: ScoredFit
    """Model with all causes that are sure, or with all if none is; the nominal model if they explain too little."""
    whole: ScoredFit
    """Model with those causes, too, that tie with a rival: what it leaves, neither of them explains."""
    rounds: tuple[SearchRound, ...]
    rivals: tuple[Rival, ...]
    unsure: tuple[Hypothesis, ...]
    """Further causes that tie with a rival, beside others that are sure; not in the final model."""
    rows: float
    """Energy of noise alone."""

    @property
    def without_causes(self) -> "SearchResult":
        """Same search with nothing found."""
        return replace(self, final=self.nominal, whole=self.nominal, rivals=(), unsure=())


def fit_and_score(
    problem: FitProblem, hypotheses: Sequence[Hypothesis], like: Fit | None = None, *, begun: bool = False
) -> ScoredFit:
    """Fit hypotheses, with tangents of others from a fit `like` it, and score the fit."""
    if not hypotheses:
        return score(problem, evaluate(problem, ()))
    return score(problem, fit(problem, hypotheses, begun=begun, like=like))


def leave_out(problem: FitProblem, found: SearchResult, absent: Sequence[Hypothesis]) -> SearchResult:
    """Leave causes out of a result, and fit the others again."""

    def without(model: ScoredFit) -> ScoredFit:
        """Fit the others of a model from where they are."""
        return fit_and_score(problem, [one for one in model.fit.hypotheses if one not in absent], begun=True)

    kept = [one for one in found.final.fit.hypotheses if one not in absent]
    if not kept:
        return found.without_causes
    final = without(found.final)
    gone = {one.label for one in absent}
    return replace(
        found,
        final=final,
        whole=final if found.whole is found.final else without(found.whole),
        rivals=tuple(rival for rival in found.rivals if rival.against not in gone),
    )


def score(problem: FitProblem, found: Fit) -> ScoredFit:
    """Score a fit by what it leaves in held-out blocks."""
    return ScoredFit(fit=found, rss_by_block=compute_held_out_rss(problem, found, found.priors))


def compute_held_out_rss(problem: FitProblem, found: Fit, priors: Priors) -> Array:
    """Compute the energy that a fit leaves in held-out blocks, mean of both splits, shape (B,)."""
    halves, motions = make_half_folds(problem.blocks), make_motion_folds(problem.blocks)
    left = [
        compute_block_rss(found.equations, folds, found.fold_columns, priors) for folds in (halves, motions) if folds
    ]
    mean: Array = np.mean(left, axis=0)
    return mean


_THERE = 1e-6
"""Practical steps from its null value within which a size is there: bounds must lie apart."""


def prune(problem: FitProblem, tried: ScoredFit, like: Fit | None = None) -> ScoredFit:
    """Prune the newest hypothesis: drop sizes without which less is left on held-out rows."""
    while True:
        # size whose absence costs least on held-out rows, by slopes
        known = tried.hypothesis.kind.parameters()
        sizes = list(dict.fromkeys(f.name for f in tried.hypothesis.list_free() if known[f.name].role == "size"))
        if len(sizes) < 2:
            break
        left = {size: _compute_rss_without(problem, tried.fit, size) for size in sizes}
        least = min(left, key=left.__getitem__)
        if left[least] >= tried.rss:
            break
        # fit without it, and keep that if it is better
        *others, newest = tried.fit.hypotheses
        try:
            fewer = score(problem, refine(problem, evaluate(problem, (*others, newest.fix_at_null(least)), like), like))
        except FAILED:
            break
        if fewer.rss >= tried.rss:
            break
        tried = fewer
    return tried


def _compute_rss_without(problem: FitProblem, fit: Fit, size: str) -> float:
    """Compute the held-out energy with one size at its null value, by slopes."""
    free, known = fit.hypotheses[-1].list_free(), fit.hypotheses[-1].kind.parameters()
    first = len(fit.priors.low) - len(free)
    low, high = fit.priors.low.copy(), fit.priors.high.copy()
    for i, number in enumerate(free):
        if number.name == size:
            null = (known[size].neutral - number.value) / number.step
            low[first + i], high[first + i] = null - _THERE, null + _THERE
    priors = Priors(precision=fit.priors.precision, low=low, high=high)
    return float(np.sum(compute_held_out_rss(problem, fit, priors)))


def refit(problem: FitProblem, adopted: ScoredFit) -> ScoredFit:
    """Refit with tangents of all causes, and more finely if anything is left to explain."""
    # tangents of earlier causes were those of an earlier fit
    if len(adopted.fit.hypotheses) > 1:
        try:
            adopted = score(problem, refine(problem, renew_tangents(problem, adopted.fit)))
        except FAILED:
            return adopted  # with the tangents that it has
    if adopted.fit.left < settings().search.finer_from * float(adopted.fit.equations.rows.sum()):
        return adopted
    finer = polish(problem, adopted.fit)
    return adopted if finer is adopted.fit else score(problem, finer)


def _fit_without(problem: FitProblem, now: ScoredFit, others: Sequence[Hypothesis]) -> ScoredFit | None:
    """Fit the other causes alone; None if they do not make up for the one that is left out."""
    limits = settings().search
    begun = evaluate(problem, others, now.fit)
    if score(problem, begun).rss > now.rss * (1 + limits.clearly_needed):
        return None
    fewer = score(problem, refine(problem, begun, now.fit, roughly=True))
    if fewer.rss > now.rss * (1 + limits.needed):
        return None
    return fit_and_score(problem, fewer.fit.hypotheses, now.fit, begun=True)


def drop_needless(problem: FitProblem, now: ScoredFit) -> ScoredFit:
    """Drop causes that the others make up for; what slopes say is enough where they come nowhere near."""
    for i in range(len(now.fit.hypotheses) - 1):
        others = [h for k, h in enumerate(now.fit.hypotheses) if k != i]
        if build_machine(problem.nominal, others) is None:
            continue
        try:
            fewer = _fit_without(problem, now, others)
        except FAILED:
            continue  # a machine without it cannot be: it is needed
        if fewer is not None:
            return drop_needless(problem, fewer)
    return now
