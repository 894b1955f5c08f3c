"""Reading of a trial: from logs to the error of each run, what must be left out and why, and the gain."""

from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.deployment.trial.commands import CHANNELS, compare_commands, read_command
from ffgym.deployment.trial.gains import Gain, estimate_gains
from ffgym.deployment.trial.matching import TrialLog, match_logs, sort_by_clock
from ffgym.deployment.trial.passes import ALIKE, Passes, ProgramPass, find_passes
from ffgym.deployment.trial.plan import PlannedRun, TrialPlan
from ffgym.deployment.trial.scoring import UNITS, Measure, Unit, score_run, sees_tool
from ffgym.logs.quality import accept_findings, check_quality, condition, notes_of
from ffgym.recordings import Recording
from ffgym.robot import RobotDescription

_NEEDED = ("timestamp", "motor.position", "tcp.position", "tcp.timestamp", *CHANNELS)
"""Columns that a trial reads; those of others, and their faults, do not matter to it."""
_NOISY = 0.1
"""Relative standard deviation of an error by noise of the sensor from which on it is told."""


@dataclass(frozen=True, kw_only=True)
class RunResult:
    """One run of the plan, and what its log says."""

    run: PlannedRun
    log: str = ""
    """Name of its log; empty without one."""
    error: float = np.nan
    """Error in the unit of the trial; NaN where there is none."""
    doubt: float = np.nan
    """Relative standard deviation of it by noise of the sensor."""
    started: float = np.nan
    """Time at which the program began, on the clock of the log [s]."""
    passes: int = 0
    """Passes of the program in the log."""
    left_out: str = ""
    """Reason why it does not count; empty if it does, or is to warm up."""

    @property
    def counts(self) -> bool:
        """True if the run is one of a pair and has an error."""
        return not self.run.is_warm_up and not self.left_out


@dataclass(frozen=True, kw_only=True, eq=False)
class TrialResult:
    """Gain that a trial shows, and every run behind it."""

    plan: TrialPlan
    measure: Measure
    runs: tuple[RunResult, ...]
    """All runs of the plan, in its order."""
    gains: tuple[Gain, ...]
    """Gain of each program, and over all where there are several."""
    notes: tuple[str, ...]
    """Sentences on what was left out, and on what casts doubt on the trial."""

    @property
    def unit(self) -> Unit:
        """Unit of the errors."""
        return UNITS[self.measure]


@dataclass(kw_only=True, eq=False)
class _Evidence:
    """Evidence that is gathered of a run on the way."""

    log: TrialLog
    passes: list[ProgramPass] = field(default_factory=list)
    command: Mapping[str, Array] = field(default_factory=dict)
    why: str = ""
    """Reason why the run does not count."""


def read_trial(
    plan: TrialPlan,
    logs: Sequence[TrialLog],
    *,
    robot: RobotDescription | None = None,
    without: Collection[int] = (),
    accept: Collection[str] = (),
) -> TrialResult:
    """Read the logs of a trial. What cannot be used is left out with the other run of its pair, and told.

    Args:
        plan: the plan that was carried out.
        logs: logs with their names; some may be missing.
        robot: the robot, for checks of quality that need its ranges and limits.
        without: numbers of runs to leave out.
        accept: checks of quality that are overruled.

    Raises:
        FFGymError: if logs cannot be matched with the plan, no pair is left, or a number or check is unknown.
    """
    _check_numbers(plan, without)
    accept = accept_findings(accept)
    matches = match_logs(plan, logs)
    reasons = dict(matches.left_out) | dict.fromkeys(without, "it was left out on request")
    notes = list(matches.notes)
    evidence: dict[int, _Evidence] = {}
    for run in plan.runs:
        if run.number in matches.logs and run.number not in without:
            found = _look_at(plan, run, matches.logs[run.number], robot, accept, notes)
            evidence[run.number] = found
            if found.why:
                reasons[run.number] = found.why
    notes += _compare_orders(plan, evidence)
    notes += _check_commands(plan, evidence, reasons)
    measure = _choose_measure(plan, evidence, reasons, notes)
    scored = [_score(run, evidence.get(run.number), reasons.get(run.number, ""), measure) for run in plan.runs]
    runs = _leave_out_pairs(scored)
    gains = estimate_gains(_collect_pairs(plan, runs))
    if not any(gain.pairs for gain in gains):
        told = "; ".join(dict.fromkeys(f"run {one.run.number}: {one.left_out}" for one in runs if one.left_out))
        raise FFGymError(f"No pair of runs is left to compare. {told}.")
    return TrialResult(plan=plan, measure=measure, runs=runs, gains=tuple(gains), notes=(*notes, *_tell(runs)))


def _check_numbers(plan: TrialPlan, without: Collection[int]) -> None:
    for number in without:
        if not 1 <= number <= len(plan.runs):
            raise FFGymError(f"Run {number} to leave out is not in the plan, which has runs 1 to {len(plan.runs)}.")


def _look_at(
    plan: TrialPlan,
    run: PlannedRun,
    log: TrialLog,
    robot: RobotDescription | None,
    accept: Collection[str],
    notes: list[str],
) -> _Evidence:
    """Condition and judge a log, find its passes, and read what was commanded."""
    found = _Evidence(log=log)
    try:
        families = [name for name in _NEEDED if log.recording.has(name)]
        names = [name for name in log.recording.columns if name.startswith(tuple(families))]
        kept = log.recording.derive({name: log.recording.columns[name] for name in names})
        recording = condition(kept)
        report = check_quality(recording, robot, accept=accept)
        if report.verdict == "insufficient":
            found.why = f"its log is insufficient: {report.problems[0].message.removesuffix('.')}"
            return found
        notes += [f"Log {log.name}: {said}" for said in (*notes_of(recording), *(p.message for p in report.problems))]
        passes = find_passes(plan.program(run.program), recording)
        found.passes = list(passes.found)
        if not found.passes:
            found.why = _explain_no_pass(plan, run, recording, passes)
            return found
        if plan.laps > 1 and len(found.passes) > 1:
            found.passes = found.passes[1:]
        elif plan.laps > 1:
            found.why = f"its log shows one lap of {plan.laps}, and the first is not scored"
            return found
        if len(passes.found) != plan.laps:
            notes.append(f"Log {log.name} shows {len(passes.found)} passes of {run.program}, planned are {plan.laps}.")
        found.command = read_command(plan.program(run.program), recording, found.passes[-1])
    except FFGymError as error:
        found.why = f"its log cannot be used: {error}"
    return found


def _explain_no_pass(plan: TrialPlan, run: PlannedRun, recording: Recording, passes: Passes) -> str:
    """Say what a log shows instead of its program."""
    others = [other for other in plan.programs if other.name != run.program]
    seen = [other.name for other in others if find_passes(other, recording).found]
    if seen:
        return f"its log shows program {seen[0]}, not {run.program}"
    if passes.paces:
        return f"it ran at {passes.paces[0]:.0%} of the speed of {run.program}"
    if not np.isfinite(passes.nearest):
        return f"its log of {recording.t[-1] - recording.t[0]:.3g} s is shorter than the program"
    return (
        f"its joints do not follow {run.program}: the best stretch is off by {passes.nearest:.0%} of the program's "
        f"extent, at most {ALIKE:.0%} is a pass (another speed, place or path?)"
    )


def _compare_orders(plan: TrialPlan, evidence: Mapping[int, _Evidence]) -> list[str]:
    """Compare the order of the runs with that of the plan, where one clock runs through all logs."""
    numbers = list(evidence)
    order = sort_by_clock([evidence[number].log.recording for number in numbers])
    if order is None:
        return []
    ran = [numbers[index] for index in order]
    late = [after for before, after in pairwise(ran) if after < before]
    if not late:
        return []
    names = ", ".join(map(str, late))
    return [
        f"By the clocks of the logs the order was not that of the plan, which chance had drawn; run too late: {names}."
    ]


def _check_commands(plan: TrialPlan, evidence: Mapping[int, _Evidence], reasons: dict[int, str]) -> list[str]:
    """Compare commands with the plan, program by program; runs that ran as the other kind do not count."""
    notes = []
    for program in plan.programs:
        own = [run for run in plan.runs if run.program == program.name and not run.is_warm_up]
        own = [run for run in own if run.number in evidence and not evidence[run.number].why]
        check = compare_commands(
            {run.number: evidence[run.number].command for run in own}, {run.number: run.corrected for run in own}
        )
        for number in check.swapped:
            run = plan.runs[number - 1]
            shown = "without the correction" if run.corrected else "with the correction"
            reasons[number] = (
                f"its {check.channel} is that of a run {shown}, planned was {run.what}: swapped, or its log mislabelled"
            )
        if not check.channel and own:
            notes.append(
                f"{program.name}: no command in the logs differs between runs with and without the correction, so that "
                f"swapped runs cannot be seen. Log commanded positions (reference.position) or the added torque."
            )
    return notes


def _choose_measure(
    plan: TrialPlan, evidence: Mapping[int, _Evidence], reasons: dict[int, str], notes: list[str]
) -> Measure:
    """Choose the tool where most runs saw it, and leave out those that did not."""
    seen = {n: all(sees_tool(p.recording) for p in e.passes) for n, e in evidence.items() if n not in reasons}
    if sum(seen.values()) * 2 < len(seen) or not any(seen.values()):
        notes.append(
            "No tracker saw the tool, so that the motors are judged: what a correction does for springs behind them "
            "is not seen, and counts as an error."
        )
        return "motors"
    for number, saw in seen.items():
        if not saw:
            reasons[number] = "no tracker saw its tool"
    return "tool"


def _score(run: PlannedRun, found: _Evidence | None, why: str, measure: Measure) -> RunResult:
    """Score one run."""
    if found is None:
        return RunResult(run=run, left_out=why)
    result = RunResult(run=run, log=found.log.name, passes=len(found.passes), left_out=why)
    if not found.passes:
        return result
    result = replace(result, started=found.passes[0].start)
    try:
        error = score_run([each.recording for each in found.passes], measure)
    except FFGymError as problem:
        return replace(result, left_out=why or f"its error cannot be computed: {problem}")
    return replace(result, error=error.size, doubt=error.doubt)


def _leave_out_pairs(runs: Sequence[RunResult]) -> tuple[RunResult, ...]:
    """Leave out runs whose partner does not count."""
    partners: dict[tuple[str, int], list[RunResult]] = defaultdict(list)
    for one in runs:
        partners[one.run.program, one.run.pair].append(one)

    def judge(one: RunResult) -> RunResult:
        if not one.counts:
            return one
        bad = [other.run.number for other in partners[one.run.program, one.run.pair] if other.left_out]
        return replace(one, left_out=f"the other run of its pair, {bad[0]}, does not count") if bad else one

    return tuple(judge(one) for one in runs)


def _collect_pairs(plan: TrialPlan, runs: Sequence[RunResult]) -> dict[str, Array]:
    """Collect errors of whole pairs by program, without and with the correction, shape (n, 2)."""
    pairs: dict[str, Array] = {}
    for program in plan.programs:
        own = [one for one in runs if one.counts and one.run.program == program.name]
        kinds = [sorted((one.run.pair, one.error) for one in own if one.run.corrected == kind) for kind in (0, 1)]
        pairs[program.name] = np.array([[error for _, error in kind] for kind in kinds]).reshape(2, -1).T
    return pairs


def _tell(runs: Sequence[RunResult]) -> list[str]:
    """Tell what was left out, and whose errors noise hides."""
    notes = [f"Run {one.run.number} ({one.run.log}) does not count: {one.left_out}." for one in runs if one.left_out]
    noisy = [str(one.run.number) for one in runs if one.counts and one.doubt > _NOISY]
    if noisy:
        notes.append(
            f"Noise of the sensor leaves more than {_NOISY:.0%} of doubt in the errors of runs {', '.join(noisy)}: "
            f"they are hardly above it, and so small that the gain is a bound rather than a number."
        )
    return notes
