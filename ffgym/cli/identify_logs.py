"""Logs that a command is to identify from: read, checked, and those for validation kept apart."""

from dataclasses import dataclass
from pathlib import Path

from ffgym.cli.log_options import Identify
from ffgym.cli.progress import progress_bar
from ffgym.core.errors import FFGymError
from ffgym.logs import read_logs as read_motions
from ffgym.logs.quality import check_quality, conditioned_alike
from ffgym.recordings import Recording
from ffgym.recordings.io import read_folder
from ffgym.robot import RobotDescription

_NEEDS = ("position", "torque")
"""What every identification takes of a log."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LogSet:
    """Recordings of one robot."""

    used: tuple[Recording, ...]
    """To identify from."""
    held_out: tuple[Recording, ...]
    """To validate with."""
    doubts: tuple[str, ...]
    """What the quality gate has against logs that are used all the same."""


def read_logs(config: Identify, robot: RobotDescription, *, known: bool = True) -> LogSet:
    """Read the recordings that a command names, or with a column map files of other tools, and condition them.

    Args:
        config: names logs to identify from, and to validate with; those that are both are for validation.
        robot: the robot that they are of.
        known: whether the description says enough for the quality gate to judge by it, masses and limits that is.

    Raises:
        FFGymError: if one cannot be read, is of another robot or not good enough, or none is left to identify from.
    """
    apart = [recording for path in config.validate for recording in _read(path, config.columns, robot)]
    named = [recording for path in config.logs for recording in _read(path, config.columns, robot)]
    given = [recording for recording in named if not any(recording.equals(other) for other in apart)]
    made = conditioned_alike([*given, *apart])
    if not given:
        raise FFGymError("All logs are for validation, so none is left to identify from.")
    doubts = []
    with progress_bar("checking", "logs") as progress:
        for i, recording in enumerate(made):
            progress(i, len(made))
            report = check_quality(recording, robot if known else None, _NEEDS)
            if report.verdict == "insufficient":
                doubts.append(f"Log {recording.header.segment!r} is insufficient: {report.problems[0].message}")
    if doubts and not config.unchecked:
        more = f" {len(doubts) - 1} more logs have problems too." if len(doubts) > 1 else ""
        raise FFGymError(f"{doubts[0]}{more} ffgym log check LOG says all; --unchecked uses such logs all the same.")
    return LogSet(used=tuple(made[: len(given)]), held_out=tuple(made[len(given) :]), doubts=tuple(doubts))


def _read(path: Path, columns: str | None, robot: RobotDescription) -> list[Recording]:
    if columns is None and path.is_dir():
        return read_folder(path)
    return read_motions(path, columns, robot=None if columns is None else robot)
