"""The quality gate: all checks of a recording, in an order in which a fault is named once, where it begins."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from ffgym.core.errors import check_choice, check_class
from ffgym.logs.quality import agreement, cells, coverage, plausible, rows, tool, torque, torque_timing, values
from ffgym.logs.quality.check import SEVERITY, STAGE_ROWS, Check, Finding, QualityReport
from ffgym.logs.quality.conditioning import condition
from ffgym.logs.quality.coverage import need_findings
from ffgym.logs.quality.even import notes_of
from ffgym.logs.quality.log import CheckedLog
from ffgym.logs.quality.signals import EVEN, is_even
from ffgym.recordings import Recording
from ffgym.robot import RobotDescription

_MODULES = (rows, plausible, values, cells, agreement, tool, torque, torque_timing, coverage)
_FOUND = [made for module in _MODULES for made in vars(module).values() if isinstance(made, Check)]
_BY_NAME = {made.name: made for made in (*_FOUND, *agreement.KINDS, *coverage.COVERAGE)}

STAGES: Mapping[str, tuple[Check, ...]] = MappingProxyType(
    {stage: tuple(_BY_NAME[name] for name in names) for stage, names in STAGE_ROWS.items()}
)
"""Checks by stage. What a stage refuses would make later ones speak of its consequences, so they are not judged."""

CONDITIONED = ("clock and header", "rows", "values")
"""Stages whose findings conditioning may mend."""

CHECKS: tuple[Check, ...] = tuple(check for checks in STAGES.values() for check in checks)
"""All checks in their order."""


_ALIKE = 1.5
"""Largest ratio of sample periods of logs that are brought to one, if their clocks are uneven."""


def check_quality(
    recording: Recording,
    robot: RobotDescription | None = None,
    needs: Iterable[str] = (),
    *,
    accept: Collection[str] = (),
) -> QualityReport:
    """Judge a recording, once it is conditioned, before anything is concluded from it.

    What conditioning mends or leaves out is flagged; what is refused cannot be left out.

    Args:
        recording: what was logged or simulated.
        robot: the robot it is said to be of; without it nothing that hangs on masses, ranges or limits is judged.
        needs: uses it must serve, see `ffgym.logs.quality.NEEDS`; without them coverage is told, not judged.
        accept: names of checks that are overruled: what they refuse is flagged.

    Raises:
        FFGymError: if an argument is of another type, or a use is unknown.
    """
    check_class("recording", recording, Recording, "read_recording makes one")
    made = condition(recording)
    log = CheckedLog(made, robot)
    findings = _found(log, accept)
    findings += need_findings(log, needs, [finding for finding in findings if finding.check not in accept])
    if made is not recording:
        mended = _list_repairs(CheckedLog(recording, robot), findings)
        findings = [*mended, *(f for f in findings if f.check not in {finding.check for finding in mended})]
    return QualityReport(
        robot=recording.header.robot,
        segment=recording.header.segment,
        n_rows=len(recording),
        duration=float(recording.t[-1] - recording.t[0]),
        findings=tuple(sorted(findings, key=lambda finding: SEVERITY[finding.verdict])),
        conditioning=notes_of(made),
    )


def _found(log: CheckedLog, accept: Collection[str]) -> list[Finding]:
    """Findings of all checks, stage by stage; those of checks that are overruled stop none."""
    findings: list[Finding] = []
    stopped = ""
    for stage, checks in STAGES.items():
        if stopped:
            message = f"Not judged: something in {stopped!r} is refused, which this would repeat. Repair that first."
            findings += [Finding(check=check.name, verdict="not judged", message=message) for check in checks]
            continue
        for finding in (finding for check in checks for finding in check.findings(log)):
            overruled = finding.verdict == "refused" and finding.check in accept
            message = f"Accepted, though refused by {finding.check}: {finding.message}"
            findings.append(replace(finding, verdict="flagged", message=message) if overruled else finding)
        if any(finding.verdict == "refused" for finding in findings):
            stopped = stage
    return findings


def _list_repairs(log: CheckedLog, others: Sequence[Finding]) -> list[Finding]:
    """Flag what conditioning repaired: findings on the log as it came that are none any more.

    Those of the first stage that has any: rows of an uneven clock, for one, seem to stick out.
    """
    left = {finding.check for finding in others if finding.verdict in ("refused", "flagged")}
    bad: list[Finding] = []
    with np.errstate(over="ignore", invalid="ignore"):  # of numbers that no machine gives
        for stage in CONDITIONED:
            checks = [check for check in STAGES[stage] if check.name not in left]
            bad = bad or [f for check in checks for f in check.findings(log) if f.verdict in ("refused", "flagged")]
    return [replace(finding, verdict="flagged", message=f"Mended or left out: {finding.message}") for finding in bad]


@dataclass(frozen=True, kw_only=True, eq=False)
class Judged:
    """Logs that serve, and what has to be known about all of them."""

    recordings: tuple[Recording, ...]
    """Conditioned, in their order."""
    left_out: tuple[str, ...]
    """Logs that are not used, and why, a sentence each."""
    flagged: tuple[str, ...]
    """Sentences on what was left out, conditioned, accepted or flagged otherwise."""


def judge_logs(
    recordings: Sequence[Recording],
    robot: RobotDescription | None = None,
    needs: Iterable[str] = (),
    accept: Iterable[str] = (),
) -> Judged:
    """Condition and judge logs; those that are refused are left out with their reason, the others are used.

    Args:
        recordings: logs of one machine.
        robot: what they are said to be of.
        needs: uses that they must serve, see `ffgym.logs.quality.NEEDS`.
        accept: names of checks that are overruled, and told.

    Raises:
        FFGymError: if a use or a check is unknown.
    """
    overruled, uses = accept_findings(accept), tuple(needs)
    kept: list[Recording] = []
    left_out: list[str] = []
    told: list[str] = []
    for recording in condition_alike(recordings):
        segment = recording.header.segment or "A log"
        report = check_quality(recording, robot, uses, accept=overruled)
        if report.verdict == "insufficient":
            left_out.append(f"{segment} was left out: {report.problems[0].message}")
            continue
        kept.append(recording)
        told += [f"{segment}: {note}" for note in notes_of(recording)]
        told += [f"{segment}: {finding.message}" for finding in report.problems]
    return Judged(recordings=tuple(kept), left_out=tuple(left_out), flagged=(*left_out, *told))


def accept_findings(names: Iterable[str]) -> tuple[str, ...]:
    """Names of checks to overrule.

    Raises:
        FFGymError: if one is unknown.
    """
    known = [check.name for check in CHECKS]
    return tuple(check_choice("check", name, known) for name in names)


def condition_alike(recordings: Sequence[Recording]) -> list[Recording]:
    """Conditioned logs; those with uneven clocks of nearly one period are brought to the same."""
    found = [condition(recording) for recording in recordings]
    uneven = [i for i, recording in enumerate(recordings) if not is_even(recording.t)]
    if not uneven:
        return found
    # the sample period that most logs have, the shortest of several
    periods = [recording.dt for recording in found]
    counts = [sum(abs(one / other - 1.0) <= EVEN for one in periods) for other in periods]
    period = min(period for period, count in zip(periods, counts, strict=True) if count == max(counts))
    for i in uneven:
        if abs(found[i].dt / period - 1.0) > EVEN and 1 / _ALIKE < found[i].dt / period < _ALIKE:
            found[i] = condition(recordings[i], period=period)
    return found
