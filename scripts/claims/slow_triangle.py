"""Record a slow triangle and identify the share behind the spring, as docs/published_robot.md says: a record."""

import json
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import tyro

from ffgym.cli.main import main as command
from ffgym.core.errors import FFGymError
from ffgym.core.files import read_text, write_json
from scripts.claims.page import ROOT

MOTION = ROOT / "docs" / "slow_triangle.toml"
NOMINAL = "irb4600_60_205"
MACHINES = ("irb4600_60_205_arm_losses", NOMINAL, "docs/backlash.toml")
SPREAD = "0.1"
"""Spread of the stiffness."""


@dataclass(frozen=True)
class Config:
    """Record the motion on three machines, and identify each."""

    json: Path
    """File of the shares."""


def main(config: Config) -> None:
    """Write the share of joint 1 and its interval for each machine."""
    write_json(config.json, {"stiffness_spread": float(SPREAD), "shares": [_identify(name) for name in MACHINES]})


def _identify(machine: str) -> dict[str, object]:
    """Record a machine, and identify it from the nominal description."""
    name = str(ROOT / machine) if machine.endswith(".toml") else machine
    with TemporaryDirectory() as folder:
        logs, found = Path(folder) / "logs", Path(folder) / "found.json"
        for call in (
            ["record", name, str(MOTION), "--out", str(logs)],
            ["identify", str(logs), "--robot", NOMINAL, "--stiffness-spread", SPREAD, "--json", str(found)],
        ):
            if command(call) != 0:
                raise FFGymError(f"ffgym {call[0]} failed.")
        first = json.loads(read_text(found))["joints"][0]
    share = first["arm_share"]
    return {"machine": machine, "joint": share["joint"], "share": share["value"], "interval": share["interval"]}


if __name__ == "__main__":
    main(tyro.cli(Config))
