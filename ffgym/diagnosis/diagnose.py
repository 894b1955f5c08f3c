"""What does the simulation get wrong, why, and how sure is that: recordings and a nominal model in, a diagnosis out."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ffgym.diagnosis.answer.blind import beside_blind, blind_rivals, told
from ffgym.diagnosis.answer.excitation import judgeable_kinds, not_excited
from ffgym.diagnosis.answer.levels import levels
from ffgym.diagnosis.answer.next_motion import next_motion
from ffgym.diagnosis.answer.sentence import sentence_of
from ffgym.diagnosis.answer.sizes import causes_of
from ffgym.diagnosis.answer.verdict import judged
from ffgym.diagnosis.calibration import Calibration
from ffgym.diagnosis.choice import Choice
from ffgym.diagnosis.first_look import FirstLook, first_look
from ffgym.diagnosis.fit.leftover import loudness, without_calibration
from ffgym.diagnosis.log import log_of
from ffgym.diagnosis.log.order import by_content
from ffgym.diagnosis.log.reference import beyond_limits
from ffgym.diagnosis.measured import check_length
from ffgym.diagnosis.one_thread import on_one_thread
from ffgym.diagnosis.patterns import find_patterns
from ffgym.diagnosis.prepare import Memory, Prepared, noise_for, prepared
from ffgym.diagnosis.residual import Residual
from ffgym.diagnosis.residuals import residual_of
from ffgym.diagnosis.result import Diagnosis
from ffgym.diagnosis.search.search import MOST, Report, search
from ffgym.errors import check_whole
from ffgym.plant import Machine
from ffgym.provenance import versions
from ffgym.quality import check_quality
from ffgym.recordings import Recording
from ffgym.robot import RobotDescription


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


def diagnose(
    nominal: Machine | RobotDescription,
    recordings: Sequence[Recording],
    *,
    calibration: Calibration | None = None,
    seed: int = 0,
    report: Report = lambda what, share: None,
    memory: Memory | None = None,
    most: int = MOST,
) -> Diagnosis:
    """Diagnose logs of a machine.

    Args:
        nominal: what the simulation believes.
        recordings: of motions with different names, sampled alike; see `ffgym record ROBOT diagnosis`.
        calibration: how well the nominal numbers are known.
        seed: of resamples and of simulated noise.
        report: told what is done.
        memory: kept from one diagnosis to the next, which is faster where many logs are of the same motions.
        most: causes to look for, 1 to 8; a diagnosis of the extended model finds further ones, and several short ones
            take less time than a long one.

    Raises:
        FFGymError: if there is nothing to diagnose, or logs and robot do not fit.
    """
    return examine(
        nominal, recordings, calibration=calibration, seed=seed, report=report, memory=memory, most=most
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
    most: int = MOST,
) -> Examined:
    """Diagnose logs of a machine, and keep what that was made from.

    Args:
        nominal: see `diagnose`.
        recordings: see there.
        calibration: see there.
        seed: see there.
        report: see there.
        first: told what stands out, soon and before anything is sure; None saves that time.
        memory: see `diagnose`.
        most: see there.
    """
    given, recordings = tuple(recordings), by_content(recordings)
    machine = Machine.of(nominal)
    check_whole("most causes", most, low=1, high=MOST)
    rng = np.random.default_rng(check_whole("seed", seed, low=0))
    flagged, refused = _quality(recordings, machine.physical)
    provenance = {"seed": seed, "versions": versions()}
    names = tuple(recording.header.segment for recording in given)
    if refused:
        insufficient = Diagnosis(
            verdict="insufficient",
            sentence=f"These logs do not allow a diagnosis: {refused[0]}",
            robot=machine.robot.name,
            motions=names,
            quality=(*refused, *flagged),
            provenance=provenance,
        )
        return Examined(diagnosis=insufficient, before=None, after=None, machine=machine, nominal=machine)
    flagged = (*flagged, *beyond_limits(machine.physical, recordings))
    report("replaying the nominal model", 0.0)
    log = log_of(machine.physical, recordings)
    check_length(log)
    known = calibration or Calibration()
    if first is not None:
        first(first_look(log, machine, known))
    ready = prepared(log, machine, known, rng, memory)
    found = _examined(machine, known, ready, rng, report, flagged, provenance, memory, most)
    return replace(found, diagnosis=replace(found.diagnosis, motions=names))


def _examined(
    machine: Machine,
    calibration: Calibration,
    ready: Prepared,
    rng: np.random.Generator,
    report: Callable[[str, float], None],
    flagged: tuple[str, ...],
    provenance: Mapping[str, object],
    memory: Memory | None,
    most: int,
) -> Examined:
    setting, log = ready.setting, ready.setting.log
    kinds, not_judgeable = judgeable_kinds(log, machine, ready.no_servo)
    report("computing what each effect would change", 0.1)
    found = search(setting, Choice(ready, kinds, memory), noise_for(ready, rng), rng, report, most)
    first = without_calibration(setting, found.nominal.fit)
    rest = without_calibration(setting, found.final.fit)
    after = residual_of(log, found.final.fit.run, rest, ready.floor)
    before = residual_of(log, found.nominal.fit.run, first, ready.floor)
    loud = loudness(setting, rest)
    blind = blind_rivals(found.final.fit.hypotheses, not_judgeable)
    verdict = beside_blind(judged(setting, found, loudness(setting, first), loud), blind)
    report("looking at what is left", 0.95)
    left = after
    if found.unsure:
        left = residual_of(log, found.whole.fit.run, without_calibration(setting, found.whole.fit), ready.floor)
    patterns = find_patterns(left, rng) if verdict.verdict in ("unknown", "partly") else ()
    causes = causes_of(found.final.fit, verdict.gains, calibration, rng)
    ties = bool(causes) and any(rival.tied for rival in found.rivals)
    rivals = (*found.rivals, *told(verdict, blind)) if causes else ()
    if ties:
        report("looking for a motion that tells rivals apart", 0.97)
    diagnosis = Diagnosis(
        verdict=verdict.verdict,
        sentence=sentence_of(verdict, causes, rivals, patterns, log.robot),
        robot=log.robot.name,
        motions=log.names,
        causes=causes,
        rivals=rivals,
        patterns=patterns,
        not_excited=not_excited(found),
        not_judgeable=not_judgeable,
        separating_motion=next_motion(found, machine, ready.floor, calibration) if ties else None,
        levels=levels(setting, found, ready.floor),
        threshold=found.rounds[0].ranking.threshold,
        quality=flagged,
        provenance=dict(provenance),
    )
    return Examined(
        diagnosis=diagnosis, before=before, after=after, machine=found.final.fit.run.machine, nominal=machine
    )


def _quality(recordings: Sequence[Recording], robot: RobotDescription) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """What the quality gate flagged, and what it refused, in words."""
    flagged, refused = [], []
    for recording in recordings:
        for finding in check_quality(recording, robot, ("diagnosis",)).findings:
            text = f"{recording.header.segment}: {finding.message}"
            if finding.verdict == "refused":
                refused.append(text)
            elif finding.verdict == "flagged":
                flagged.append(text)
    return tuple(flagged), tuple(refused)
