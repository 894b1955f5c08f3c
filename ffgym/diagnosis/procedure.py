"""Diagnosis of a simulation: recordings and a nominal model in, causes with sizes and how sure they are out.

This file has the steps in order: judge the log, replay the nominal model, estimate noise, search for causes, conclude.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from ffgym.core.errors import check_whole
from ffgym.core.provenance import versions
from ffgym.diagnosis.band import choose_cutoff
from ffgym.diagnosis.computing import on_one_thread
from ffgym.diagnosis.excitation import Preview, preview
from ffgym.diagnosis.log import assemble_log, sort_by_content
from ffgym.diagnosis.log_columns import report_beyond_limits
from ffgym.diagnosis.nuisance import ParameterPrior
from ffgym.diagnosis.passes import Examination, Pass
from ffgym.diagnosis.prepare import (
    DiagnosisCache,
    explains_all,
    fit_within_prior,
    prepare,
)
from ffgym.diagnosis.residual_rows import check_length
from ffgym.diagnosis.result import Diagnosis, Miswiring
from ffgym.diagnosis.search.search import Report
from ffgym.diagnosis.settings import settings
from ffgym.diagnosis.thinning import read_notes, thin
from ffgym.logs.quality import condition_alike, judge_logs
from ffgym.logs.quality.wiring import Wiring, find_wiring
from ffgym.recordings import Recording
from ffgym.robot import RobotDescription
from ffgym.simulation.plant import Machine


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
    look = partial(Pass, machine=machine, prior=known, rng=rng, report=report, most=most, said=said)
    about = fit_within_prior(ready, known, rng) if known.share >= limits.loose else None
    found = look(ready).search(cache) if about is None else look(about).search()
    # numbers that were fitted alone may have taken up a part of a cause, and made it unlike itself
    if about is not None and found.diagnosis.verdict == "unknown" and not found.causes:
        report("diagnosing about numbers as described", 0.0)
        found = look(ready).search(cache)
    if about is not None and found.causes:
        report("fitting numbers beside the causes", 0.0)
        again = fit_within_prior(ready, known, rng, found.of.ready.problem.as_described(found.causes))
        found = look(ready if again is None else again).search()
    # numbers that are known well are the reason only if they explain all
    if found.diagnosis.verdict != "none" and known.share < limits.loose:
        about = fit_within_prior(ready, known, rng, thoroughly=False)
        if about is not None and explains_all(ready, about):
            report("diagnosing about numbers within their calibration", 0.0)
            found = look(about).search()
        elif (
            len(found.causes) > len(found.diagnosis.causes) > 0
            and (beside := fit_within_prior(ready, known, rng, found.causes)) is not None
        ):
            # what a cause explained that may be nothing is explained by numbers beside the others
            report("diagnosing about numbers fitted beside the causes", 0.0)
            found = found.replace_by_fewer(look(beside).search())
    # what causes leave may be noise that was not seen beside them
    found = found.search_above_noise()
    # name the motions that were used, in the order in which they were given
    used = {recording.header.segment for recording in recordings}
    motions = tuple(name for name in names if name in used)
    return replace(found.examination, diagnosis=replace(found.diagnosis, motions=motions))


def _report_miswiring(wiring: Wiring, said: Mapping[str, Any]) -> Diagnosis:
    """Report columns that are not what they are called, in place of what the gate says of them."""
    entries = tuple(
        Miswiring(kind=one.kind, families=one.families, joints=one.joints, message=one.message)
        for one in wiring.mistakes
    )
    more = f" {len(entries) - 1} more of the kind." if len(entries) > 1 else ""
    sentence = f"Columns of these logs are not what they are called. {entries[0].message}{more}"
    return Diagnosis(verdict="wiring", sentence=sentence, wiring=entries, **dict(said) | {"quality": ()})
