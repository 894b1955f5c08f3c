"""Passes of a diagnosis: a search for causes about some numbers of the machine, and what follows from it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ffgym.diagnosis.drift import find_drifts
from ffgym.diagnosis.excitation import add_leads, list_not_excited, sort_effects
from ffgym.diagnosis.extended import list_fitted_numbers
from ffgym.diagnosis.fit.fit import Trial, loudness, subtract_nuisances
from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.fit.written import build_extended_model
from ffgym.diagnosis.nuisance import ParameterPrior
from ffgym.diagnosis.patterns import find_patterns
from ffgym.diagnosis.prepare import (
    DiagnosisCache,
    PreparedSearch,
    renew_floor,
)
from ffgym.diagnosis.replay import Replay
from ffgym.diagnosis.residual import Residual
from ffgym.diagnosis.residual_rows import assemble_residual
from ffgym.diagnosis.result import Diagnosis
from ffgym.diagnosis.search.candidates import draw_surrogates
from ffgym.diagnosis.search.generator import CandidateGenerator
from ffgym.diagnosis.search.rounds import SearchResult, leave_out
from ffgym.diagnosis.search.search import Report, search
from ffgym.diagnosis.search.significance import is_within_prior
from ffgym.diagnosis.separation import propose_next_motion
from ffgym.diagnosis.settings import settings
from ffgym.diagnosis.sizes import compute_held_out_gain, compute_levels, is_there, list_causes
from ffgym.diagnosis.verdict import (
    describe_explained,
    judge,
    list_blind_rivals,
    select_reported,
    weaken_for_blind_rivals,
    write_sentence,
)
from ffgym.recordings import Rewiring
from ffgym.simulation.plant import Machine


@dataclass(frozen=True, kw_only=True, eq=False)
class Examination:
    """Diagnosis with its residuals and models, for pictures, gains and the next experiment."""

    diagnosis: Diagnosis
    before: Residual | None
    """Residual of the nominal model; None if the logs did not allow one."""
    after: Residual | None
    """Residual of the extended model."""
    machine: Machine
    """The extended model: the nominal one with the causes."""
    nominal: Machine
    rewiring: Rewiring = field(default_factory=Rewiring)
    """Mended reading of columns, if the verdict is `wiring`."""


def names_only(found: Diagnosis, causes: Sequence[Hypothesis]) -> bool:
    """Tell whether a diagnosis names some of these causes without reserve, and no others."""
    named = {(cause.effect, cause.joint) for cause in found.causes}
    return found.verdict == "named" and named <= {(cause.kind.name, cause.joint) for cause in causes}


@dataclass(frozen=True, eq=False)
class Pass:
    """One pass over a log, about some numbers of the machine."""

    ready: PreparedSearch
    machine: Machine
    prior: ParameterPrior
    rng: np.random.Generator
    report: Report
    most: int
    said: Mapping[str, Any]
    """Entries of the diagnosis that are known before."""

    def search(self, cache: DiagnosisCache | None = None) -> "PassResult":
        """Search for causes and conclude."""
        ready, problem, rng = self.ready, self.ready.problem, self.rng
        # candidates, and surrogate residuals from which the threshold comes
        kinds = sort_effects(problem.log, problem.nominal, self.prior, ready.no_servo)[0]
        self.report("computing what each effect would change", 0.1)
        null_residuals = draw_surrogates(ready.null.draws, problem.blocks, problem.nuisance_columns, rng)
        found = search(problem, CandidateGenerator(ready, kinds, cache), null_residuals, rng, self.report, self.most)
        causes = tuple(one for one in found.whole.fit.hypotheses if not is_within_prior(problem, one))
        examined = self._conclude_written(found)
        # causes that may as well not be there, beside the others or with the numbers fitted, are none
        while absent := [
            one
            for one, cause in zip(found.final.fit.hypotheses, examined.diagnosis.causes, strict=False)
            if not is_there(cause)
        ]:
            found = leave_out(problem, found, absent)
            examined = self._conclude_written(found)
        return PassResult(of=self, model=found.final.fit.run, examination=examined, causes=causes)

    def _conclude_written(self, found: SearchResult) -> Examination:
        """Write causes and fitted numbers as one model, and conclude."""
        problem = self.ready.problem
        model = build_extended_model(problem, found.final.fit, self.prior) if found.final.fit.hypotheses else None
        if model is not None and any(one.is_null or is_within_prior(problem, one) for one in model.hypotheses):
            # numbers within their calibration do what the causes seemed to do
            found, model = found.without_causes, None
        return self.conclude(found, model)

    def conclude(self, found: SearchResult, model: Trial | None) -> Examination:
        """Turn the outcome of a search into a diagnosis, with what it was made from."""
        ready, problem, log, prior = self.ready, self.ready.problem, self.ready.problem.log, self.prior
        # residuals of the nominal and the final model, nuisance parameters taken off
        not_judgeable = sort_effects(log, problem.nominal, prior, ready.no_servo)[1]
        first = subtract_nuisances(problem, found.nominal.fit)
        rest = subtract_nuisances(problem, found.final.fit)
        after = assemble_residual(log, found.final.fit.run, rest, ready.floor)
        before = assemble_residual(log, found.nominal.fit.run, first, ready.floor)
        loud = loudness(problem, rest)
        # verdict, weakened by rivals that the log cannot show
        sees_arm = log.tool is not None or log.link is not None
        blind = list_blind_rivals(found.final.fit.hypotheses, not_judgeable, sees_arm=sees_arm)
        verdict = weaken_for_blind_rivals(judge(problem, found, loudness(problem, first), loud), blind)
        self.report("looking at what is left", 0.95)
        # patterns of what is left, if that is more than noise
        left = after
        if found.unsure:
            left = assemble_residual(
                log, found.whole.fit.run, subtract_nuisances(problem, found.whole.fit), ready.floor
            )
        is_left = verdict.verdict in ("unknown", "partly") or max(loud.values()) > settings().significance.quiet
        patterns = find_patterns(left, self.rng) if is_left else ()
        # sizes with intervals, and the gain on held-out motions
        final = found.final.fit
        gain = compute_held_out_gain(problem, found.nominal.fit, final, prior) if model is not None else None
        if model is not None:
            final = replace(final, hypotheses=model.hypotheses)
        causes = list_causes(final, verdict.gains, prior, self.rng)
        # rivals that tie call for a motion that tells them apart
        ties = bool(causes) and any(rival.tied for rival in found.rivals)
        rivals = (*found.rivals, *select_reported(verdict, blind)) if causes else ()
        if ties:
            self.report("looking for a motion that tells rivals apart", 0.97)
        quiet = list_not_excited(found)
        residuals = (found.nominal.fit.residual,) * 2 if gain is None else (gain.before, gain.after)
        levels = compute_levels(log, *residuals, ready.floor)
        share = describe_explained(verdict, causes, levels, len(log.names))
        diagnosis = Diagnosis(
            **dict(self.said) | {"robot": log.robot.name, "motions": log.names},
            verdict=verdict.verdict,
            sentence=write_sentence(verdict, causes, rivals, patterns, log.robot, share, levels),
            causes=causes,
            numbers=() if model is None else list_fitted_numbers(self.machine, model.numbers),
            drifts=find_drifts(log, found.final.fit.run, rest, problem.blocks),
            rivals=rivals,
            patterns=add_leads(patterns, causes, rivals, quiet, not_judgeable),
            not_excited=quiet,
            not_judgeable=not_judgeable,
            separating_motion=propose_next_motion(found, problem.nominal, ready.floor, prior) if ties else None,
            levels=levels,
            gains=gain is not None and gain.is_better,
            threshold=found.rounds[0].ranking.threshold,
        )
        extended = self.machine if model is None else model.machine
        return Examination(diagnosis=diagnosis, before=before, after=after, machine=extended, nominal=self.machine)


@dataclass(frozen=True, kw_only=True, eq=False)
class PassResult:
    """Diagnosis of a pass, with the causes that it found."""

    of: Pass
    model: Replay
    """Replay of the log with what was found."""
    examination: Examination
    causes: tuple[Hypothesis, ...]
    """All causes that are no number within its prior."""

    @property
    def diagnosis(self) -> Diagnosis:
        """Its diagnosis."""
        return self.examination.diagnosis

    def replace_by_fewer(self, other: "PassResult") -> "PassResult":
        """Return another result if it names some of these causes alone, fewer than there are; else this one."""
        is_fewer = len(other.diagnosis.causes) < len(self.causes) and names_only(other.diagnosis, self.causes)
        return other if is_fewer else self

    def search_above_noise(self) -> "PassResult":
        """Search again above the noise that causes leave, if something is left that this noise may be.

        Noise that stays from row to row is louder in the band than above it, which shows only where no cause lies over
        it. What is then found replaces this result if it names some of the same causes, and leaves nothing.
        """
        if self.diagnosis.verdict != "partly":
            return self
        ready = renew_floor(self.of.ready, self.model, self.of.rng)
        if ready is None:
            return self
        self.of.report("searching above the noise that causes leave", 0.0)
        again = replace(self.of, ready=ready).search()
        return again if names_only(again.diagnosis, self.causes) else self
