"""The quality gate: all checks of a recording, in an order in which a fault is named once, where it begins."""

from collections.abc import Iterable, Mapping
from types import MappingProxyType

from ffgym.errors import FFGymError
from ffgym.quality.agreement import AGREEMENT
from ffgym.quality.cells import CELLS
from ffgym.quality.check import Check
from ffgym.quality.clock import CLOCK
from ffgym.quality.coverage import COVERAGE
from ffgym.quality.finding import Finding, QualityReport, worst_first
from ffgym.quality.gravity import GRAVITY
from ffgym.quality.identity import IDENTITY
from ffgym.quality.levels import LEVELS
from ffgym.quality.log import Log
from ffgym.quality.needs import need_findings
from ffgym.quality.plausible import PLAUSIBLE, SIZE
from ffgym.quality.rows import ROWS
from ffgym.quality.sampling import SAMPLING
from ffgym.quality.stuck import STUCK
from ffgym.quality.timing import TIMING
from ffgym.quality.tool import TOOL
from ffgym.quality.torque import TORQUE
from ffgym.quality.torque_timing import TORQUE_TIMING
from ffgym.recordings import Recording
from ffgym.robot import RobotDescription

STAGES: Mapping[str, tuple[Check, ...]] = MappingProxyType(
    {
        "clock and header": (*SIZE, *CLOCK, *IDENTITY),
        "rows": ROWS,
        "values": (*STUCK, *LEVELS, *CELLS),
        "columns against each other": (*AGREEMENT, *TIMING),
        "sizes": PLAUSIBLE,
        "tool": TOOL,
        "torque": (*TORQUE_TIMING, *TORQUE, *GRAVITY),
        "sampling": SAMPLING,
        "coverage": COVERAGE,
    }
)
"""Checks by stage. What a stage refuses would make later ones speak of its consequences, so they are not judged."""

CHECKS: tuple[Check, ...] = tuple(check for checks in STAGES.values() for check in checks)
"""All checks in their order."""


def check_quality(
    recording: Recording, robot: RobotDescription | None = None, needs: Iterable[str] = ()
) -> QualityReport:
    """Judge a recording before anything is concluded from it.

    Args:
        recording: what was logged or simulated.
        robot: the robot it is said to be of; without it nothing that hangs on masses, ranges or limits is judged.
        needs: uses it must serve, see `ffgym.quality.NEEDS`; without them coverage is told, not judged.

    Raises:
        FFGymError: if an argument is of another type, or a use is unknown.
    """
    if not isinstance(recording, Recording):
        raise FFGymError(f"recording must be a Recording, got {type(recording).__name__}; read_recording makes one.")
    log = Log(recording, robot)
    findings: list[Finding] = []
    stopped = ""
    for stage, checks in STAGES.items():
        if stopped:
            findings += [_not_judged(check, stopped) for check in checks]
            continue
        found = [finding for check in checks for finding in check.findings(log)]
        findings += found
        if any(finding.verdict == "refused" for finding in found):
            stopped = stage
    findings += need_findings(log, needs, findings)
    return QualityReport(
        robot=recording.header.robot,
        segment=recording.header.segment,
        n_rows=len(recording),
        duration=float(recording.t[-1] - recording.t[0]),
        findings=worst_first(findings),
    )


def _not_judged(check: Check, stage: str) -> Finding:
    message = f"Not judged: something in {stage!r} is refused, which this would repeat. Repair that first."
    return Finding(check=check.name, verdict="not judged", message=message)
