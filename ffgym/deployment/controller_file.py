"""File of a controller: delay and smoothing filter, and gains of its servo, as identified or as its manual says."""

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ffgym.control import SetpointResponse
from ffgym.core.errors import FFGymError, check_shape, errors_at
from ffgym.core.files import read_text, write_text
from ffgym.core.toml import parse_toml, toml_table
from ffgym.core.types import Array
from ffgym.robot import RobotDescription
from ffgym.robot.parts import Servo

_TABLE = "setpoints"
_UNITS = {"delay": "s", "lag": "s", "curvature": "s^2"}
_SERVO = "servo"
_GAINS = {"position_gain": "N m/rad", "velocity_gain": "N m s/rad", "integral_gain": "N m/(rad s)"}


def write_controller(
    path: str | os.PathLike[str],
    response: SetpointResponse,
    *,
    source: str,
    intervals: Mapping[str, tuple[float, float]] | None = None,
    servo: Servo | None = None,
    joints: Sequence[str] = (),
    gain_intervals: Mapping[str, Array] | None = None,
    documented: Sequence[str] = (),
) -> None:
    """Write a controller as TOML.

    Args:
        path: file, .toml.
        response: delay and filter.
        source: where the numbers come from.
        intervals: 95 % intervals of delay and filter by name, in SI units.
        servo: gains that were found, motor side; None writes none, so that documented ones hold.
        joints: names of the servo's joints.
        gain_intervals: 95 % intervals of gains by name, motor side, (N, 2) each.
        documented: gains among them that were not found and are those of the description, as joint.gain.

    Raises:
        FFGymError: if the file cannot be written.
    """
    entries: dict[str, Any] = {"source": source}
    for name in _UNITS:
        entries[name] = getattr(response, name)
        entries[f"{name}_interval"] = (intervals or {}).get(name)
    lines = [
        f"# {response.describe()}",
        "# delay [s], lag a_1 [s], curvature a_2 [s^2]: exp(-delay s) / (1 + a_1 s + a_2 s^2)",
        *toml_table(_TABLE, entries),
    ]
    if servo is not None:
        gains: dict[str, Any] = {"source": source, "joints": list(joints)}
        for name in _GAINS:
            gains[name] = getattr(servo, name)
            gains[f"{name}_interval"] = (gain_intervals or {}).get(name)
        gains["documented"] = list(documented) or None
        units = ", ".join(f"{name} [{unit}]" for name, unit in _GAINS.items())
        lines += ["", f"# motor side: {units}", *toml_table(_SERVO, gains)]
    write_text(path, "\n".join([*lines, ""]))


def read_controller(path: str | os.PathLike[str]) -> SetpointResponse:
    """Read delay and filter of a controller; entries that are left out are 0.

    Raises:
        FFGymError: if the file cannot be read, or is none of a controller.
    """
    with errors_at(str(path)):
        table = _read_table(path, _TABLE, {*_UNITS, *(f"{name}_interval" for name in _UNITS), "source"})
        if table is None:
            raise FFGymError(f"There is no table [{_TABLE}]; ffgym identify controller writes one.")
        return SetpointResponse(**{name: table[name] for name in _UNITS if name in table})


def read_servo(path: str | os.PathLike[str], robot: RobotDescription) -> Servo | None:
    """Read the gains of a controller's servo, with the control step of a robot; None if the file has none.

    Raises:
        FFGymError: if the file cannot be read, or its gains are not those of the robot's joints.
    """
    intervals = {f"{name}_interval" for name in _GAINS}
    with errors_at(str(path)):
        table = _read_table(path, _SERVO, {*_GAINS, *intervals, "source", "joints", "documented"})
        if table is None:
            return None
        if table.get("joints", [*robot.joints]) != [*robot.joints]:
            raise FFGymError(
                f"joints = {table['joints']} of [{_SERVO}] must be {list(robot.joints)}, those of {robot.name}."
            )
        position, velocity, integral = (_read_gains(table, name, robot) for name in _GAINS)
        return replace(robot.servo, position_gain=position, velocity_gain=velocity, integral_gain=integral)


def _read_gains(table: Mapping[str, Any], name: str, robot: RobotDescription) -> Array:
    """Read one gain of all joints."""
    if name not in table:
        raise FFGymError(f"[{_SERVO}] has no {name}; it must have {', '.join(_GAINS)}, one number per joint.")
    values = check_shape(f"servo.{name}", table[name], (robot.n_joints,))
    least = 0.0 if name == "integral_gain" else np.nextafter(0.0, 1.0)
    if not np.all(values >= least):
        raise FFGymError(f"servo.{name} = {values.tolist()} must be {'>= 0' if least == 0 else '> 0'} on every joint.")
    return values


def _read_table(path: str | os.PathLike[str], name: str, known: set[str]) -> dict[str, Any] | None:
    """Read one table of the file and check its entries; None if there is none."""
    table = parse_toml(read_text(path), "The file").get(name)
    if not isinstance(table, dict):
        return None
    if unknown := sorted(set(table) - known):
        raise FFGymError(f"Unknown entries of [{name}]: {', '.join(unknown)}. Known: {', '.join(sorted(known))}.")
    return table
