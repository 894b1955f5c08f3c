"""Logs that a command is to identify from: read, checked, and those for validation kept apart."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

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

    robot: RobotDescription
    """As it is described before."""
    used: tuple[Recording, ...]
    """To identify from."""
    held_out: tuple[Recording, ...]
    """To validate with."""
    doubts: tuple[str, ...]
    """What the quality gate has against logs that are used all the same."""


def read_logs(
    robot: RobotDescription,
    logs: Sequence[Path],
    validate: Sequence[Path],
    *,
    columns: str | None = None,
    unchecked: bool = False,
    known: bool = True,
) -> LogSet:
    """Read recordings and folders of them, or with `columns` files of other tools, and condition them.

    Args:
        robot: the robot that they are of.
        logs: to identify from; those that are also in `validate` are kept out.
        validate: to validate with.
        columns: column map of all logs; None for recordings.
        unchecked: whether to use what the quality gate calls insufficient.
        known: whether the description says enough for the quality gate to judge by it, masses and limits that is.

    Raises:
        FFGymError: if one cannot be read, is of another robot or not good enough, or none is left to identify from.
    """
    apart = [recording for path in validate for recording in _read(path, columns, robot)]
    given = [r for path in logs for r in _read(path, columns, robot) if not any(r.equals(other) for other in apart)]
    made = conditioned_alike([*given, *apart])
    used, held_out = made[: len(given)], made[len(given) :]
    if not used:
        raise FFGymError("All logs are for validation, so none is left to identify from.")
    doubts = _doubts([*used, *held_out], robot if known else None)
    if doubts and not unchecked:
        more = f" {len(doubts) - 1} more logs have problems too." if len(doubts) > 1 else ""
        raise FFGymError(f"{doubts[0]}{more} ffgym log check LOG says all; --unchecked uses such logs all the same.")
    return LogSet(robot=robot, used=tuple(used), held_out=tuple(held_out), doubts=tuple(doubts))


def _read(path: Path, columns: str | None, robot: RobotDescription) -> list[Recording]:
    if columns is None and path.is_dir():
        return read_folder(path)
    return read_motions(path, columns, robot=None if columns is None else robot)


def _doubts(recordings: Sequence[Recording], robot: RobotDescription | None) -> list[str]:
    """What the quality gate has against recordings."""
    found = []
    with progress_bar("checking", "logs") as progress:
        for i, recording in enumerate(recordings):
            progress(i, len(recordings))
            found.append(_doubt(recording, robot))
    return [doubt for doubt in found if doubt]


def _doubt(recording: Recording, robot: RobotDescription | None) -> str:
    """Why a recording is not good enough; empty if it is."""
    report = check_quality(recording, robot, _NEEDS)
    if report.verdict != "insufficient":
        return ""
    return f"Log {recording.header.segment!r} is insufficient: {report.problems[0].message}"
