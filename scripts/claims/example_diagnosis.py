"""Diagnose the example logs, as docs/diagnosis.md shows: a record of `make claims`."""

from dataclasses import dataclass
from pathlib import Path

import tyro

from ffgym.core.files import write_json
from ffgym.diagnosis import EXAMPLE_ROBOT, diagnose, example_logs
from ffgym.report import format_diagnosis
from ffgym.robot import load_robot


@dataclass(frozen=True)
class Config:
    """Diagnose the example logs."""

    json: Path
    """File of what is printed."""


def main(config: Config) -> None:
    """Write the lines that tell the causes of the example logs, and how long these are."""
    logs = example_logs()
    found = diagnose(load_robot(EXAMPLE_ROBOT), logs)
    duration = sum(float(log.t[-1] - log.t[0]) for log in logs)
    write_json(config.json, {"duration_s": duration, "printed": format_diagnosis(found).splitlines()})


if __name__ == "__main__":
    main(tyro.cli(Config))
