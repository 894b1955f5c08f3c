"""Workcell files: a machine file with a payload, sensors, and the model that the controller has of the machine.

    [workcell]                       controller, and maybe `like`, another workcell that this one changes
    [machine], [friction.*], ...     see ffgym.simulation.plant.machine_file; equations of the workcell count as effects
    [payload.mass]                   a point mass at the TCP that the controller does not know
    [sensors.*]                      noise and resolution of each sensor

Every number has its value, unit and source; the source begins with sourced, derived, chosen or calibrated.
"""

import tomllib
from collections.abc import Mapping
from functools import cache
from importlib import resources
from typing import Any

import numpy as np

from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.toml import merge_tables
from ffgym.core.types import Array
from ffgym.effects import EFFECTS
from ffgym.effects.reading import given_value
from ffgym.robot import RigidArm, load_robot
from ffgym.simulation import LaserTracker, Resolver, Thermometer, TorqueSensor
from ffgym.simulation.plant import with_payload
from ffgym.simulation.plant.machine_file import parse_machine
from ffgym.workcell.cell import SealedMachine, Workcell
from ffgym.workcell.equations import EQUATIONS

_UNITS = {
    "payload.mass": "kg",
    "sensors.resolver_bits": "bit/turn",
    "sensors.resolver_noise": "rad",
    "sensors.torque_noise": "N m",
    "sensors.tracker_noise": "m",
    "sensors.tracker_period": "s",
    "sensors.thermometer_noise": "K",
    "sensors.thermometer_resolution": "K",
}
"""Units of the numbers beside those of the machine."""

Tree = dict[str, Any]

INSTANCES = ("thesis", "thesis_arm", "thesis_drives", "cold", "worn", "heavy_tool")
"""Names of the workcells that ship with the package, each a file in `data`."""


@cache
def workcell(name: str) -> Workcell:
    """Load a workcell by its name.

    Raises:
        FFGymError: if no workcell has that name.
    """
    return build(check_choice("workcell", name, INSTANCES), read_tree(name))


def read_tree(name: str) -> Tree:
    """Read tables of a workcell file of the package, merged into those of the file that it is like."""
    text = (resources.files("ffgym.workcell") / "data" / f"{name}.toml").read_text(encoding="utf-8")
    tree = tomllib.loads(text)
    like = tree["workcell"].pop("like", None)
    return tree if like is None else merge_tables(read_tree(like), tree)


def build(name: str, tree: Mapping[str, Any], arm: RigidArm | None = None) -> Workcell:
    """Build a workcell from parsed tables.

    Its controller knows `arm`, by default the robot that the tables name.
    """
    own = ("workcell", "payload", "sensors")
    tables = {key: value for key, value in tree.items() if key not in own}
    machine = parse_machine(tables, where=f"Workcell {name}", known=dict(EFFECTS) | dict(EQUATIONS))
    payload = _number("payload.mass", tree["payload"]["mass"])
    seen = {key: _number(f"sensors.{key}", table) for key, table in tree["sensors"].items()}
    sealed = SealedMachine(
        label=name,
        robot=with_payload(machine.robot, payload),
        effects=machine.effects,
        climate=machine.climate,
    )
    return Workcell(
        name=name,
        title=tree["machine"]["title"],
        controller=tree["workcell"]["controller"],
        arm=arm or RigidArm(load_robot(tree["workcell"]["controller"])),
        machine=sealed,
        sensors=(
            Resolver(bits=int(seen["resolver_bits"]), noise=seen["resolver_noise"]),
            TorqueSensor(noise=seen["torque_noise"]),
            LaserTracker(noise=seen["tracker_noise"], period=seen["tracker_period"]),
            Thermometer(noise=seen["thermometer_noise"], resolution=seen["thermometer_resolution"]),
        ),
    )


def _number(where: str, table: Any) -> Any:
    """Return the value of an entry, a number or an array."""
    check_choice("entry", where, list(_UNITS))
    value: Array = np.asarray(given_value(where, table, _UNITS[where]), dtype=np.float64)
    if "source" not in table:
        raise FFGymError(f"{where} = {table!r} must have a source.")
    return value if value.ndim else float(value)
