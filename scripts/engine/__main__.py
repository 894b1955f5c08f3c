"""Command line: does the installed MuJoCo move robots and environments as the one of the record did?"""

import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import tyro

from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.files import check_writable, write_json
from ffgym.core.registration import ENVIRONMENTS
from scripts.engine.record import RECORD, Record, about_now, difference, read_record, write_record
from scripts.engine.trajectories import Trajectory, move_by_second_engine, recorded_things, robot_in


@dataclass(frozen=True)
class Config:
    """Compare robots and environments with their record: exit code 0 if all are the same to the bit, else 1."""

    names: tuple[str, ...] = ()
    """Robots and ids of environments; none is all."""
    record: Path = RECORD
    """Record to compare with, or to write."""
    store: bool = False
    """Write the record of what is installed, after the differences from the one before were looked at."""
    json: Path | None = None
    """File for all differences, with the versions of both."""


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """Answer for a robot or an environment."""

    name: str
    answer: str
    """'same', 'differs', 'has other coordinates' or 'not recorded'."""
    differs_by: float | None = None
    """Largest difference, as a share of the way of its coordinate."""
    at: float | None = None
    """Instant of it [s]."""
    since: float | None = None
    """First instant at which a bit differs [s]."""
    record_from_second: float | None = None
    """Difference of the record from the second engine, likewise."""
    now_from_second: float | None = None
    """Difference of what is installed from it."""
    robot: str | None = None
    """Robot that an environment has, on which the second engine may be asked."""

    def __str__(self) -> str:
        line = f"{self.name:40} {self.answer}"
        if self.differs_by is not None:
            line += f" by {self.differs_by:.1e} of its motion at {self.at:.3f} s, since {self.since:.3f} s"
        if self.record_from_second is not None and self.now_from_second is not None:
            nearer = "now" if self.now_from_second < self.record_from_second else "the record"
            line += f"; nearer to the second engine is {nearer} ({self.record_from_second:.1e}, "
            line += f"now {self.now_from_second:.1e})"
        elif self.differs_by is not None and self.robot is not None:
            line += f"; for the second engine see {self.robot}"
        return line


def main(config: Config) -> int:
    """Compare, print a line each, and return the exit code.

    Raises:
        FFGymError: if a name is unknown, or there is no record.
    """
    things = recorded_things()
    chosen = [check_choice("name", name, list(things)) for name in config.names] or list(things)
    if config.store and config.names:
        raise FFGymError("--store writes the record of all robots and environments; leave --names out.")
    for path in (config.json, config.record if config.store else None):
        if path is not None:
            check_writable(path)
    known = (
        Record(about={}, trajectories={}) if config.store and not config.record.exists() else read_record(config.record)
    )
    now = about_now()
    for name in sorted({**known.about, **now}):
        before, after = known.about.get(name, "none"), now.get(name, "none")
        print(f"{name:12} {after if before == after else f'{before} -> {after}'}")
    made: dict[str, Trajectory] = {}
    verdicts = []
    for name in chosen:
        made[name] = things[name]()
        verdicts.append(judge(name, known, made[name]))
        print(verdicts[-1], flush=True)
    gone = sorted(set(known.trajectories) - set(things)) if not config.names else []
    for name in gone:
        print(f"{name:40} gone")
    print(f"{sum(v.answer == 'same' for v in verdicts)} of {len(verdicts)} are the same to the bit")
    if config.json is not None:
        rows = [asdict(verdict) for verdict in verdicts]
        write_json(config.json, {"record": dict(known.about), "now": now, "verdicts": rows, "gone": gone})
    if config.store:
        write_record(config.record, made)
        print(f"wrote {config.record}")
        return 0
    return int(bool(gone) or any(verdict.answer != "same" for verdict in verdicts))


def judge(name: str, known: Record, now: Trajectory) -> Verdict:
    """Compare a trajectory with its record, and where they differ, both with the second engine."""
    before = known.trajectories.get(name)
    if before is None:
        return Verdict(name=name, answer="not recorded")
    if before.values.shape != now.values.shape:
        return Verdict(name=name, answer="has other coordinates")
    found = difference(before, now)
    if found is None:
        return Verdict(name=name, answer="same")
    numbers: dict[str, Any] = {"differs_by": found.largest, "at": found.at, "since": found.since}
    if name in ENVIRONMENTS:
        numbers["robot"] = robot_in(name)
    else:
        second = move_by_second_engine(name)
        for key, one in (("record_from_second", before), ("now_from_second", now)):
            away = difference(second, one)
            numbers[key] = 0.0 if away is None else away.largest
    return Verdict(name=name, answer="differs", **numbers)


def run(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; errors are one line."""
    try:
        return main(tyro.cli(Config, args=arguments, prog="python -m scripts.engine"))
    except FFGymError as error:
        print(f"engine: error: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(run())
