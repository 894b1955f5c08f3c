"""The prior of the calibration: the nominal robot, and the effects and surroundings of `prior.toml`."""

import tomllib
from pathlib import Path
from typing import Any

from ffgym.robot import RobotDescription
from scripts.workcell.free import File, changed_entries, table_at

FILE = Path(__file__).parent / "prior.toml"
"""Effects, payload, temperatures and sensors."""

_SLIPPING = "effects.slip_elements.level"


def prior_trees(nominal: RobotDescription) -> dict[File, dict[str, Any]]:
    """Tables of the machine and of its controller's model before the calibration."""
    trees: dict[File, dict[str, Any]] = {"machine": tomllib.loads(FILE.read_text(encoding="utf-8")), "controller": {}}
    for file, entry in sorted(changed_entries()):
        group, _, name = entry.partition(".")
        if entry in nominal.quantities:  # the others are in the file
            trees[file].setdefault(group, {})[name] = _table(nominal, entry)
    _without_slip_elements(trees["machine"], nominal)
    return trees


def _table(nominal: RobotDescription, entry: str) -> dict[str, Any]:
    """An entry of the nominal robot; what was fitted there is where this fit begins."""
    quantity = nominal.quantities[entry]
    return {
        "value": quantity.value.tolist(),
        "unit": quantity.unit.split(", ")[0],
        "side": quantity.side,
        "origin": ["derived" if origin == "fitted" else origin for origin in quantity.origin],
        "source": f"the nominal robot's: {quantity.source}",
    }


def _without_slip_elements(machine: dict[str, Any], nominal: RobotDescription) -> None:
    """Take off the LuGre friction what slip elements carry, so that their sum is the friction that is known."""
    shares = [
        1 - slip / coulomb
        for slip, coulomb in zip(table_at(machine, _SLIPPING)["value"], nominal.friction.coulomb, strict=True)
    ]
    for name in ("coulomb", "static", "bristle_stiffness", "bristle_damping"):
        table = machine["friction"][name]
        table["value"] = [value * share for value, share in zip(table["value"], shares, strict=True)]
