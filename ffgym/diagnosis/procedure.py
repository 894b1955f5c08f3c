"""Diagnosis of a simulation: recordings and a nominal model in, causes with sizes and how sure they are out.

This file has the steps in order: judge the log, replay the nominal model, estimate noise, search for causes, conclude.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from ffgym.core.errors import check_whole
from ffgym.core.provenance import versions
from ffgym.diagnosis.band import choose_cutoff
from ffgym.diagnosis.computing import on_one_thread
from ffgym.diagnosis.drift import find_drifts
from ffgym.diagnosis.excitation import Preview, add_leads, list_not_excited, preview, sort_effects
from ffgym.diagnosis.extended import list_fitted_numbers
from ffgym.diagnosis.fit.fit import Trial, loudness, subtract_nuisances
from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.fit.written import build_extended_model
from ffgym.diagnosis.log import assemble_log, sort_by_content
from ffgym.diagnosis.log_columns import report_beyond_limits
from ffgym.diagnosis.nuisance import ParameterPrior
from ffgym.diagnosis.patterns import find_patterns
from ffgym.diagnosis.prepare import (
    DiagnosisCache,
    PreparedSearch,
    explains_all,
    fit_within_prior,
    prepare,
)
from ffgym.diagnosis.residual import Residual
from ffgym.diagnosis.residual_rows import assemble_residual, check_length
from ffgym.diagnosis.result import Diagnosis, Miswiring
from ffgym.diagnosis.search.candidates import draw_surrogates
from ffgym.diagnosis.search.generator import CandidateGenerator
from ffgym.diagnosis.search.rounds import SearchResult, leave_out
from ffgym.diagnosis.search.search import Report, search
from ffgym.diagnosis.search.significance import is_within_prior
from ffgym.diagnosis.separation import propose_next_motion
from ffgym.diagnosis.settings import settings
from ffgym.diagnosis.sizes import compute_held_out_gain, compute_levels, is_there, list_causes
from ffgym.diagnosis.thinning import read_notes, thin
from ffgym.diagnosis.verdict import (
    describe_explained,
    judge,
    list_blind_rivals,
    select_reported,
    weaken_for_blind_rivals,
    write_sentence,
)
from ffgym.logs.quality import condition_alike, judge_logs
from ffgym.logs.quality.wiring import Wiring, find_wiring
from ffgym.recordings import Recording, Rewiring
from ffgym.robot import RobotDescription
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


def diagnose(
    nominal: Machine | RobotDescription,
    recordings: Sequence[Recording],
    *,
    prior: ParameterPrior | None = None,
    seed: int = 0,
    report: Report = lambda what, share: None,
    cache: DiagnosisCache | None = None,
    most: int | None = None,
    accept: Sequence[str] = (),
) -> Diagnosis:
    """Diagnose logs of a machine.

    Args:
        nominal: what the simulation believes.
        recordings: of motions with different names, sampled alike; see `ffgym record ROBOT diagnosis`. Of a log that
            is too long, stretches are used (`ffgym.diagnosis.thinning`), and told.
        prior: how well the nominal numbers are known.
        seed: of resamples and of simulated noise.
        report: told what is done.
        cache: kept from one diagnosis to the next, which is faster where many logs are of the same motions.
        most: causes to look for, 1 to 8, None for 8; a diagnosis of the extended model finds further ones, and several
            short ones take less time than a long one.
        accept: names of checks of quality that are overruled, and told.

    Raises:
        FFGymError: if there is nothing to diagnose, or logs and robot do not fit.
    """
    return examine(
        nominal, recordings, prior=prior, seed=seed, report=report, cache=cache, most=most, accept=accept
    ).diagnosis


@on_one_thread
def examine(
    nominal: Machine | RobotDescription,
    recordings: Sequence[Recording],
    *,
    prior: ParameterPrior | None = None,
    seed: int = 0,
    report: Report = lambda what, share: None,
    first: Callable[[Preview], None] | None = None,
    cache: DiagnosisCache | None = None,
    most: int | None = None,
    accept: Sequence[str] = (),
) -> Examination:
    """Diagnose logs of a machine, as `diagnose` does, and keep what that was made from.

    `first` receives a preview of what stands out, soon and before anything is sure; None saves that time.
    """
    # check the arguments; thin a long log, and bring recordings into an order of their own
    limits = settings().prior
    given = tuple(thin(recordings))
    machine = Machine.of(nominal)
    high = settings().search.most_causes
    most = high if most is None else check_whole("most causes", most, low=1, high=high)
    rng = np.random.default_rng(check_whole("seed", seed, low=0))
    recordings = condition_alike(sort_by_content(given))
    # judge the quality of the logs, and keep what is to be reported in any case
    quality = judge_logs(recordings, machine.physical, ("diagnosis",), accept)
    names = tuple(recording.header.segment for recording in given)
    said: dict[str, Any] = {
        "robot": machine.robot.name,
        "motions": names,
        "quality": (*read_notes(given), *quality.flagged),
        "provenance": {"seed": seed, "versions": versions()},
    }
    # columns that are not what they are called, or logs without use, end the diagnosis
    wiring = find_wiring(recordings, machine.physical)
    nothing: dict[str, Any] = {"before": None, "after": None, "machine": machine, "nominal": machine}
    if wiring.mistakes:
        return Examination(diagnosis=_report_miswiring(wiring, said), rewiring=wiring.rewiring, **nothing)
    if not quality.recordings and recordings:
        sentence = f"These logs do not allow a diagnosis: {quality.left_out[0]}"
        return Examination(diagnosis=Diagnosis(verdict="insufficient", sentence=sentence, **said), **nothing)
    # assemble the log in the band in which the model can be compared
    report("replaying the nominal model", 0.0)
    recordings = quality.recordings
    said["quality"] = (*said["quality"], *report_beyond_limits(machine.physical, recordings))
    log = assemble_log(machine.physical, recordings)
    check_length(log)
    if (cutoff := choose_cutoff(log, machine)) < log.sampling.cutoff:
        log = assemble_log(machine.physical, recordings, cutoff=cutoff)
    known = prior or ParameterPrior()
    if first is not None:
        first(preview(log, machine, known))
    # replay the nominal model and estimate what noise alone leaves
    ready = prepare(log, machine, known, rng, cache)
    # loosely known numbers are fitted first, alone, and then together with the causes that are found about them
    look = partial(_Pass, machine=machine, prior=known, rng=rng, report=report, most=most, said=said)
    about = fit_within_prior(ready, known, rng) if known.share >= limits.loose else None
    found, causes = look(ready).search(cache) if about is None else look(about).search()
    if about is not None and causes:
        report("fitting numbers beside the causes", 0.0)
        again = fit_within_prior(ready, known, rng, about.problem.as_described(causes))
        found, _ = look(ready if again is None else again).search()
    # numbers that are known well are the reason only if they explain all
    if found.diagnosis.verdict != "none" and known.share < limits.loose:
        about = fit_within_prior(ready, known, rng, thoroughly=False)
        if about is not None and explains_all(ready, about):
            report("diagnosing about numbers within their calibration", 0.0)
            found, _ = look(about).search()
        elif (
            len(causes) > len(found.diagnosis.causes) > 0
            and (beside := fit_within_prior(ready, known, rng, causes)) is not None
        ):
            # what a cause explained that may be nothing is explained by numbers beside the others
            report("diagnosing about numbers fitted beside the causes", 0.0)
            fewer, _ = look(beside).search()
            found = fewer if names_fewer(fewer.diagnosis, causes) else found
    # name the motions that were used, in the order in which they were given
    used = {recording.header.segment for recording in recordings}
    motions = tuple(name for name in names if name in used)
    return replace(found, diagnosis=replace(found.diagnosis, motions=motions))


def names_fewer(found: Diagnosis, causes: Sequence[Hypothesis]) -> bool:
    """Tell whether a diagnosis names some of these causes without reserve, fewer and no others."""
    named = {(cause.effect, cause.joint) for cause in found.causes}
    return found.verdict == "named" and named < {(cause.kind.name, cause.joint) for cause in causes}


@dataclass(frozen=True, eq=False)
class _Pass:
    """One pass over a log, about some numbers of the machine."""

    ready: PreparedSearch
    machine: Machine
    prior: ParameterPrior
    rng: np.random.Generator
    report: Report
    most: int
    said: Mapping[str, Any]
    """Entries of the diagnosis that are known before."""

    def search(self, cache: DiagnosisCache | None = None) -> tuple[Examination, tuple[Hypothesis, ...]]:
        """Search for causes and conclude; return, too, all causes that are no number within its prior."""
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
        return examined, causes

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


def _report_miswiring(wiring: Wiring, said: Mapping[str, Any]) -> Diagnosis:
    """Report columns that are not what they are called, in place of what the gate says of them."""
    entries = tuple(
        Miswiring(kind=one.kind, families=one.families, joints=one.joints, message=one.message)
        for one in wiring.mistakes
    )
    more = f" {len(entries) - 1} more of the kind." if len(entries) > 1 else ""
    sentence = f"Columns of these logs are not what they are called. {entries[0].message}{more}"
    return Diagnosis(verdict="wiring", sentence=sentence, wiring=entries, **dict(said) | {"quality": ()})
