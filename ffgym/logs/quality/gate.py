"""The quality gate: all checks of a recording, in an order in which a fault is named once, where it begins."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.logs.quality.agreement import AGREEMENT
from ffgym.logs.quality.cells import CELLS
from ffgym.logs.quality.check import Check
from ffgym.logs.quality.clock import CLOCK
from ffgym.logs.quality.conditioning import conditioned, notes_of
from ffgym.logs.quality.coverage import COVERAGE
from ffgym.logs.quality.finding import Finding, QualityReport, worst_first
from ffgym.logs.quality.gravity import GRAVITY
from ffgym.logs.quality.identity import IDENTITY
from ffgym.logs.quality.levels import LEVELS
from ffgym.logs.quality.log import Log
from ffgym.logs.quality.masked import MASKED
from ffgym.logs.quality.needs import need_findings
from ffgym.logs.quality.plausible import PLAUSIBLE, SIZE
from ffgym.logs.quality.rows import ROWS
from ffgym.logs.quality.sampling import SAMPLING
from ffgym.logs.quality.stuck import STUCK
from ffgym.logs.quality.timing import TIMING
from ffgym.logs.quality.tool import TOOL
from ffgym.logs.quality.torque import TORQUE
from ffgym.logs.quality.torque_timing import TORQUE_TIMING
from ffgym.recordings import Recording
from ffgym.robot import RobotDescription

STAGES: Mapping[str, tuple[Check, ...]] = MappingProxyType(
    {
        "clock and header": (*SIZE, *CLOCK, *IDENTITY),
        "rows": ROWS,
        "values": (*STUCK, *LEVELS, *CELLS, *MASKED),
        "columns against each other": (*AGREEMENT, *TIMING),
        "sizes": PLAUSIBLE,
        "tool": TOOL,
        "torque": (*TORQUE_TIMING, *TORQUE, *GRAVITY),
        "sampling": SAMPLING,
        "coverage": COVERAGE,
    }
)
"""Checks by stage. What a stage refuses would make later ones speak of its consequences, so they are not judged."""

CONDITIONED = ("clock and header", "rows", "values")
"""Stages whose findings conditioning may mend."""

CHECKS: tuple[Check, ...] = tuple(check for checks in STAGES.values() for check in checks)
"""All checks in their order."""


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
    if not isinstance(recording, Recording):
        raise FFGymError(f"recording must be a Recording, got {type(recording).__name__}; read_recording makes one.")
    made = conditioned(recording)
    log = Log(made, robot)
    findings = _found(log, accept)
    findings += need_findings(log, needs, [finding for finding in findings if finding.check not in accept])
    if made is not recording:
        mended = _mended(Log(recording, robot), findings)
        findings = [*mended, *(f for f in findings if f.check not in {finding.check for finding in mended})]
    return QualityReport(
        robot=recording.header.robot,
        segment=recording.header.segment,
        n_rows=len(recording),
        duration=float(recording.t[-1] - recording.t[0]),
        findings=worst_first(findings),
        conditioning=notes_of(made),
    )


def _found(log: Log, accept: Collection[str]) -> list[Finding]:
    """Findings of all checks, stage by stage; those of checks that are overruled stop none."""
    findings: list[Finding] = []
    stopped = ""
    for stage, checks in STAGES.items():
        if stopped:
            findings += [_not_judged(check, stopped) for check in checks]
            continue
        found = [_overruled(finding, accept) for check in checks for finding in check.findings(log)]
        findings += found
        if any(finding.verdict == "refused" for finding in found):
            stopped = stage
    return findings


def _overruled(finding: Finding, accept: Collection[str]) -> Finding:
    if finding.check not in accept or finding.verdict != "refused":
        return finding
    return replace(
        finding, verdict="flagged", message=f"Accepted, though refused by {finding.check}: {finding.message}"
    )


def _mended(log: Log, others: Sequence[Finding]) -> list[Finding]:
    """What conditioning mended, flagged: findings on the log as it came that are none any more.

    Those of the first stage that has any: rows of an uneven clock, for one, seem to stick out.
    """
    left = {finding.check for finding in others if finding.verdict in ("refused", "flagged")}
    bad: list[Finding] = []
    with np.errstate(over="ignore", invalid="ignore"):  # of numbers that no machine gives
        for stage in CONDITIONED:
            checks = [check for check in STAGES[stage] if check.name not in left]
            bad = bad or [f for check in checks for f in check.findings(log) if f.verdict in ("refused", "flagged")]
    return [replace(finding, verdict="flagged", message=f"Mended or left out: {finding.message}") for finding in bad]


def _not_judged(check: Check, stage: str) -> Finding:
    message = f"Not judged: something in {stage!r} is refused, which this would repeat. Repair that first."
    return Finding(check=check.name, verdict="not judged", message=message)
