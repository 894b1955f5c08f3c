"""Measure, identify, compensate on the workcell `thesis`, as docs/workcell.md says: a record of `make claims`."""

import json
import re
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import tyro

from ffgym.cli.main import main as command
from ffgym.core.errors import FFGymError
from ffgym.core.files import read_text, write_json
from scripts.claims.page import ROOT

PAGE = ROOT / "docs" / "workcell.md"
HEADING = "## Measure, identify, compensate"
CELL, NOMINAL, OLD = "workcell:thesis", "irb4600_60_205", "irb4600_60_205_commissioned"
CIRCLES = ("--speeds-mm-s", "10", "40")


@dataclass(frozen=True)
class Config:
    """Record, check, identify, and run circles with the old and with the identified parameters."""

    json: Path
    """File of what each command wrote."""


def main(config: Config) -> None:
    """Run the commands in a folder of their own."""
    section = read_text(PAGE).partition(HEADING)[2]
    (session,) = re.findall(r"```toml\n(.*?)```", section, flags=re.DOTALL)[:1]
    with TemporaryDirectory() as folder:
        place = Path(folder)
        (place / "session.toml").write_text(session, encoding="utf-8")
        logs, parameters = str(place / "logs"), str(place / "parameters.toml")
        recorded = _run(place, "record", CELL, str(place / "session.toml"), "--out", logs)
        files = sorted(map(str, Path(logs).glob("*.npz")))
        checked = _run(place, "log", "check", *files, "--robot", NOMINAL)
        identified = _run(place, "identify", logs, "--robot", OLD, "--out", parameters)
        before = _run(place, "demo", "--robot", CELL, *CIRCLES, "--agents", "none", "lugre_dynamic")
        after = _run(place, "demo", "--robot", CELL, *CIRCLES, "--agents", "lugre_dynamic", "--parameters", parameters)
    written = summarise(recorded, checked, identified, before, after)
    write_json(config.json, written)


def summarise(recorded: Any, checked: Any, identified: Any, before: Any, after: Any) -> dict[str, Any]:
    """Keep what the pages tell: motions, verdicts, parameters with intervals, and RMS path errors of circles [mm]."""
    parameters = [
        {key: each[key] for key in ("joint", "name", "value", "interval", "status")}
        for joint in identified["joints"]
        for each in joint["parameters"]
    ]
    circles = {
        when: [
            {key: row[key] for key in ("agent", "position", "radius_mm", "speed_mm_s", "rms_mm")} for row in of["rows"]
        ]
        for when, of in (("before", before), ("after", after))
    }
    return {
        "motions": len(recorded["motions"]),
        "verdicts": dict(Counter(log["verdict"] for log in checked["logs"])),
        "seconds": sum(log["duration"] for log in checked["logs"]),
        "physics_fingerprint": recorded["physics_fingerprint"],
        "parameters": parameters,
        **circles,
    }


def _run(place: Path, *arguments: str) -> Any:
    """Run a command of ffgym; returns what it writes as JSON."""
    out = place / "out.json"
    extra = ("--report", str(place / "report.html"), "--no-diagnosis") if arguments[0] == "demo" else ()
    if command([*arguments, *extra, "--json", str(out)]) != 0:
        raise FFGymError(f"ffgym {' '.join(arguments)} failed.")
    return json.loads(read_text(out))


if __name__ == "__main__":
    main(tyro.cli(Config))
