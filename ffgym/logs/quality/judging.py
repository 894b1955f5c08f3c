"""Logs that are to be used together: conditioned, judged, and what is not good enough left out."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import final

from ffgym.core.errors import check_choice
from ffgym.logs.quality.conditioning import conditioned, notes_of
from ffgym.logs.quality.gate import CHECKS, check_quality
from ffgym.logs.quality.intervals import EVEN, is_even
from ffgym.recordings import Recording
from ffgym.robot import RobotDescription

_ALIKE = 1.5
"""Largest ratio of sample periods of logs that are brought to one, if their clocks are uneven."""


@final
@dataclass(frozen=True, kw_only=True)
class LeftOut:
    """A log that is not used."""

    segment: str
    reason: str

    def __str__(self) -> str:
        return f"{self.segment} was left out: {self.reason}"


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Judged:
    """Logs that serve, and what has to be known about all of them."""

    recordings: tuple[Recording, ...]
    """Conditioned, in their order."""
    left_out: tuple[LeftOut, ...]
    flagged: tuple[str, ...]
    """What was left out, what conditioning did, what was accepted, and what else was flagged."""


def judged(
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
    overruled, uses = accepted(accept), tuple(needs)
    kept: list[Recording] = []
    left_out: list[LeftOut] = []
    told: list[str] = []
    for recording in conditioned_alike(recordings):
        segment = recording.header.segment or "A log"
        report = check_quality(recording, robot, uses, accept=overruled)
        if report.verdict == "insufficient":
            left_out.append(LeftOut(segment=segment, reason=report.problems[0].message))
            continue
        kept.append(recording)
        told += [f"{segment}: {note}" for note in notes_of(recording)]
        told += [f"{segment}: {finding.message}" for finding in report.problems]
    return Judged(recordings=tuple(kept), left_out=tuple(left_out), flagged=(*map(str, left_out), *told))


def accepted(names: Iterable[str]) -> tuple[str, ...]:
    """Names of checks to overrule.

    Raises:
        FFGymError: if one is unknown.
    """
    known = [check.name for check in CHECKS]
    return tuple(check_choice("check", name, known) for name in names)


def conditioned_alike(recordings: Sequence[Recording]) -> list[Recording]:
    """Conditioned logs; those with uneven clocks of nearly one period are brought to the same."""
    found = [conditioned(recording) for recording in recordings]
    uneven = [i for i, recording in enumerate(recordings) if not is_even(recording.t)]
    if not uneven:
        return found
    period = _usual([recording.dt for recording in found])
    for i in uneven:
        if abs(found[i].dt / period - 1.0) > EVEN and 1 / _ALIKE < found[i].dt / period < _ALIKE:
            found[i] = conditioned(recordings[i], period=period)
    return found


def _usual(periods: Sequence[float]) -> float:
    """The sample period that most logs have, the shortest of several."""
    counts = [sum(abs(one / other - 1.0) <= EVEN for one in periods) for other in periods]
    return min(period for period, count in zip(periods, counts, strict=True) if count == max(counts))
