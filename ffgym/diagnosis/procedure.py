"""What does the simulation get wrong, why, and how sure is that: recordings and a nominal model in, a diagnosis out."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from ffgym.core.errors import check_whole
from ffgym.core.provenance import versions
from ffgym.diagnosis.band import comparison_cutoff
from ffgym.diagnosis.by_recording import drifts
from ffgym.diagnosis.calibration import Calibration
from ffgym.diagnosis.choice import Choice
from ffgym.diagnosis.computing import on_one_thread
from ffgym.diagnosis.excitation import FirstLook, first_look, judgeable_kinds, not_excited, with_leads
from ffgym.diagnosis.extended import fitted_numbers
from ffgym.diagnosis.fit.fit import Trial, loudness, without_calibration
from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.fit.written import written
from ffgym.diagnosis.log import by_content, log_of
from ffgym.diagnosis.log_columns import beyond_limits
from ffgym.diagnosis.measured import check_length, residual_of
from ffgym.diagnosis.patterns import find_patterns
from ffgym.diagnosis.prepare import Memory, Prepared, explains_all, prepared, within_calibration
from ffgym.diagnosis.residual import Residual
from ffgym.diagnosis.result import Diagnosis, Miswiring
from ffgym.diagnosis.search.candidates import surrogates
from ffgym.diagnosis.search.found import Found
from ffgym.diagnosis.search.search import Report, search
from ffgym.diagnosis.search.worth import is_known
from ffgym.diagnosis.separation import next_motion
from ffgym.diagnosis.settings import settings
from ffgym.diagnosis.sizes import causes_of, held_out_gain, is_there, levels
from ffgym.diagnosis.thinning import note_of, thin
from ffgym.diagnosis.verdict import beside_blind, blind_rivals, judged, sentence_of, told
from ffgym.logs.quality import conditioned_alike
from ffgym.logs.quality import judged as judged_logs
from ffgym.logs.quality.wiring import Wiring, find_wiring
from ffgym.recordings import Recording, Rewiring
from ffgym.robot import RobotDescription
from ffgym.simulation.plant import Machine


@dataclass(frozen=True, kw_only=True, eq=False)
class Examined:
    """A diagnosis with what it was made from, for pictures, gains and the next experiment."""

    diagnosis: Diagnosis
    before: Residual | None
    """Of the nominal model; None if the logs did not allow one."""
    after: Residual | None
    """Of the extended model."""
    machine: Machine
    """The extended model: the nominal one with the causes."""
    nominal: Machine
    rewiring: Rewiring = field(default_factory=Rewiring)
    """How columns should be read, if the verdict is `wiring`."""


def diagnose(
    nominal: Machine | RobotDescription,
    recordings: Sequence[Recording],
    *,
    calibration: Calibration | None = None,
    seed: int = 0,
    report: Report = lambda what, share: None,
    memory: Memory | None = None,
    most: int = settings().search.most_causes,
    accept: Sequence[str] = (),
) -> Diagnosis:
    """Diagnose logs of a machine.

    Args:
        nominal: what the simulation believes.
        recordings: of motions with different names, sampled alike; see `ffgym record ROBOT diagnosis`. Of a log that
            is too long, stretches are used (`ffgym.diagnosis.thinning`), and told.
        calibration: how well the nominal numbers are known.
        seed: of resamples and of simulated noise.
        report: told what is done.
        memory: kept from one diagnosis to the next, which is faster where many logs are of the same motions.
        most: causes to look for, 1 to 8; a diagnosis of the extended model finds further ones, and several short ones
            take less time than a long one.
        accept: names of checks of quality that are overruled, and told.

    Raises:
        FFGymError: if there is nothing to diagnose, or logs and robot do not fit.
    """
    return examine(
        nominal, recordings, calibration=calibration, seed=seed, report=report, memory=memory, most=most, accept=accept
    ).diagnosis


@on_one_thread
def examine(
    nominal: Machine | RobotDescription,
    recordings: Sequence[Recording],
    *,
    calibration: Calibration | None = None,
    seed: int = 0,
    report: Report = lambda what, share: None,
    first: Callable[[FirstLook], None] | None = None,
    memory: Memory | None = None,
    most: int = settings().search.most_causes,
    accept: Sequence[str] = (),
) -> Examined:
    """Diagnose logs of a machine, as `diagnose` does, and keep what that was made from.

    `first` is told what stands out, soon and before anything is sure; None saves that time.
    """
    limits = settings().prior
    given = tuple(thin(recordings))
    machine = Machine.of(nominal)
    check_whole("most causes", most, low=1, high=settings().search.most_causes)
    rng = np.random.default_rng(check_whole("seed", seed, low=0))
    recordings = conditioned_alike(by_content(given))
    quality = judged_logs(recordings, machine.physical, ("diagnosis",), accept)
    names = tuple(recording.header.segment for recording in given)
    said: dict[str, Any] = {
        "robot": machine.robot.name,
        "motions": names,
        "quality": (*note_of(given), *quality.flagged),
        "provenance": {"seed": seed, "versions": versions()},
    }
    wiring = find_wiring(recordings, machine.physical)
    nothing: dict[str, Any] = {"before": None, "after": None, "machine": machine, "nominal": machine}
    if wiring.mistakes:
        return Examined(diagnosis=_miswired(wiring, said), rewiring=wiring.rewiring, **nothing)
    if not quality.recordings and recordings:
        sentence = f"These logs do not allow a diagnosis: {quality.left_out[0]}"
        return Examined(diagnosis=Diagnosis(verdict="insufficient", sentence=sentence, **said), **nothing)
    report("replaying the nominal model", 0.0)
    recordings = quality.recordings
    said["quality"] = (*said["quality"], *beyond_limits(machine.physical, recordings))
    log = log_of(machine.physical, recordings)
    check_length(log)
    if (cutoff := comparison_cutoff(log, machine)) < log.sampling.cutoff:
        log = log_of(machine.physical, recordings, cutoff=cutoff)
    known = calibration or Calibration()
    if first is not None:
        first(first_look(log, machine, known))
    ready = prepared(log, machine, known, rng, memory)
    # loosely known numbers are fitted first, alone, and then together with the causes that are found about them
    look = partial(_Look, machine=machine, calibration=known, rng=rng, report=report, most=most, said=said)
    about = within_calibration(ready, known, rng) if known.share >= limits.loose else None
    found, causes = look(ready).search(memory) if about is None else look(about).search()
    if about is not None and causes:
        report("fitting numbers beside the causes", 0.0)
        again = within_calibration(ready, known, rng, about.setting.as_described(causes))
        found, _ = look(ready if again is None else again).search()
    # numbers that are known well are the reason only if they explain all
    if found.diagnosis.verdict != "none" and known.share < limits.loose:
        about = within_calibration(ready, known, rng, thoroughly=False)
        if about is not None and explains_all(ready, about):
            report("diagnosing about numbers within their calibration", 0.0)
            found, _ = look(about).search()
    used = {recording.header.segment for recording in recordings}
    motions = tuple(name for name in names if name in used)
    return replace(found, diagnosis=replace(found.diagnosis, motions=motions))


@dataclass(frozen=True, eq=False)
class _Look:
    """A look at a log about some numbers of the machine."""

    ready: Prepared
    machine: Machine
    calibration: Calibration
    rng: np.random.Generator
    report: Report
    most: int
    said: Mapping[str, Any]
    """Entries of the diagnosis that are known before."""

    def search(self, memory: Memory | None = None) -> tuple[Examined, tuple[Hypothesis, ...]]:
        """Search for causes and conclude; beside that all causes that are no number within its calibration."""
        ready, setting, rng = self.ready, self.ready.setting, self.rng
        kinds = judgeable_kinds(setting.log, setting.nominal, self.calibration, ready.no_servo)[0]
        self.report("computing what each effect would change", 0.1)
        faultless = surrogates(ready.faultless.draws, setting.blocks, setting.calibration, rng)
        found = search(setting, Choice(ready, kinds, memory), faultless, rng, self.report, self.most)
        causes = tuple(one for one in found.whole.fit.hypotheses if not is_known(setting, one))
        model = written(setting, found.final.fit, self.calibration) if found.final.fit.hypotheses else None
        if model is not None and any(one.is_null or is_known(setting, one) for one in model.hypotheses):
            # numbers within their calibration do what the causes seemed to do
            found, model = found.without_causes, None
        examined = self.conclude(found, model)
        if (named := examined.diagnosis.causes) and not any(is_there(cause) for cause in named):
            examined = self.conclude(found.without_causes, None)
        return examined, causes

    def conclude(self, found: Found, model: Trial | None) -> Examined:
        """Turn the outcome of a search into a diagnosis, with what it was made from."""
        ready, setting, log, calibration = self.ready, self.ready.setting, self.ready.setting.log, self.calibration
        not_judgeable = judgeable_kinds(log, setting.nominal, calibration, ready.no_servo)[1]
        first = without_calibration(setting, found.nominal.fit)
        rest = without_calibration(setting, found.final.fit)
        after = residual_of(log, found.final.fit.run, rest, ready.floor)
        before = residual_of(log, found.nominal.fit.run, first, ready.floor)
        loud = loudness(setting, rest)
        blind = blind_rivals(found.final.fit.hypotheses, not_judgeable)
        verdict = beside_blind(judged(setting, found, loudness(setting, first), loud), blind)
        self.report("looking at what is left", 0.95)
        left = after
        if found.unsure:
            left = residual_of(log, found.whole.fit.run, without_calibration(setting, found.whole.fit), ready.floor)
        is_left = verdict.verdict in ("unknown", "partly") or max(loud.values()) > settings().significance.quiet
        patterns = find_patterns(left, self.rng) if is_left else ()
        final = found.final.fit
        gain = held_out_gain(setting, found.nominal.fit, final, calibration) if model is not None else None
        if model is not None:
            final = replace(final, hypotheses=model.hypotheses)
        causes = causes_of(final, verdict.gains, calibration, self.rng)
        ties = bool(causes) and any(rival.tied for rival in found.rivals)
        rivals = (*found.rivals, *told(verdict, blind)) if causes else ()
        if ties:
            self.report("looking for a motion that tells rivals apart", 0.97)
        quiet = not_excited(found)
        residuals = (found.nominal.fit.residual,) * 2 if gain is None else (gain.before, gain.after)
        diagnosis = Diagnosis(
            **dict(self.said) | {"robot": log.robot.name, "motions": log.names},
            verdict=verdict.verdict,
            sentence=sentence_of(verdict, causes, rivals, patterns, log.robot),
            causes=causes,
            numbers=() if model is None else fitted_numbers(self.machine, model.numbers),
            drifts=drifts(log, found.final.fit.run, rest, setting.blocks),
            rivals=rivals,
            patterns=with_leads(patterns, causes, rivals, quiet, not_judgeable),
            not_excited=quiet,
            not_judgeable=not_judgeable,
            separating_motion=next_motion(found, setting.nominal, ready.floor, calibration) if ties else None,
            levels=levels(setting, *residuals, ready.floor),
            gains=gain is not None and gain.is_better,
            threshold=found.rounds[0].ranking.threshold,
        )
        extended = self.machine if model is None else model.machine
        return Examined(diagnosis=diagnosis, before=before, after=after, machine=extended, nominal=self.machine)


def _miswired(wiring: Wiring, said: Mapping[str, Any]) -> Diagnosis:
    """Answer where columns are not what they are called; what the gate says of them repeats that."""
    entries = tuple(
        Miswiring(kind=one.kind, families=one.families, joints=one.joints, message=one.message)
        for one in wiring.mistakes
    )
    more = f" {len(entries) - 1} more of the kind." if len(entries) > 1 else ""
    sentence = f"Columns of these logs are not what they are called. {entries[0].message}{more}"
    return Diagnosis(verdict="wiring", sentence=sentence, wiring=entries, **dict(said) | {"quality": ()})
