"""The numbers of an arm file as entries of a robot description, each with its origin."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ffgym.core.errors import check_shape
from ffgym.core.types import Array
from ffgym.robot.arm_file.arm_file import ArmFile, JointHints, Kind
from ffgym.robot.arm_file.measure import Pose, geometry, masses
from ffgym.robot.reading.quantity import Quantity
from ffgym.robot.reading.rule import JointFrame, si_units
from ffgym.robot.reading.rules import RULES

UNLIMITED = 2 * np.pi
"""Range of a hinge without limits, to both sides [rad]: one turn, what cables along an arm usually bear."""


def quantities_of(
    pose: Pose, hints: Sequence[JointHints], file: str, kind: Kind, *, has_masses: bool
) -> dict[str, Quantity]:
    """Entries by path; `file` is their source, and without masses those of the links are left out.

    Raises:
        FFGymError: if a link weighs nothing, or a number is not finite.
    """
    joints = JointFrame(types=pose.chain.types)
    with np.errstate(over="ignore", invalid="ignore"):  # numbers that overflow are refused below
        values = geometry(pose) | (masses(pose) if has_masses else {})
    entries = {path: _quantity(path, value, ("sourced",), file, joints) for path, value in values.items()}
    if not has_masses:
        source = f"{file} has no masses; a base that stands still needs none"
        still = {"base.mass": np.zeros(()), "base.com": np.zeros(3)}
        entries |= {path: _quantity(path, value, ("chosen",), source, joints) for path, value in still.items()}
    path, gravity = "simulation.gravity", pose.model.opt.gravity
    if kind == "urdf":
        entries[path] = _quantity(path, gravity, ("chosen",), f"{file} says none; URDF has z upwards", joints)
    else:
        entries[path] = _quantity(path, gravity, ("sourced",), file, joints)
    entries |= _range(pose, file, joints)
    if all(hint.speed is not None for hint in hints):
        speeds = np.array([hint.speed for hint in hints])
        path = "kinematics.max_speed"
        entries[path] = _quantity(path, speeds, ("sourced",), file, joints)
    return entries


def flange_at(arm: ArmFile, frame: str) -> dict[str, Quantity]:
    """Entries that put tool0, and the TCP as long as nothing else is said of it, at a named frame of the file.

    Raises:
        FFGymError: if the last link has no such frame.
    """
    place, source = arm.frame(frame), f"{Path(arm.path).name}, frame {frame}"
    joints = JointFrame(types=arm.types)
    entries = {"flange.position": place.position, "flange.rotation": place.rotation}
    found = {path: _quantity(path, value, ("sourced",), source, joints) for path, value in entries.items()}
    return found | {"tool.tcp": _quantity("tool.tcp", np.zeros(3), ("chosen",), f"origin of frame {frame}", joints)}


def _range(pose: Pose, file: str, joints: JointFrame) -> dict[str, Quantity]:
    """Joint limits; none at all if a sliding joint has none, as nothing says how far it could go."""
    chosen = list(pose.chain.joints)
    limited = pose.model.jnt_limited[chosen].astype(bool)
    hinges = np.array([kind == "hinge" for kind in joints.types])
    if not np.all(limited | hinges):
        return {}
    path = "kinematics.range"
    limits = np.where(limited[:, None], pose.model.jnt_range[chosen], UNLIMITED * np.array([-1.0, 1.0]))
    origin = tuple("sourced" if known else "chosen" for known in limited)
    source = file if np.all(limited) else f"{file}; one turn to both sides where it gives no limits"
    return {path: _quantity(path, limits, origin, source, joints)}


def _quantity(path: str, value: Array, origin: tuple[str, ...], source: str, joints: JointFrame) -> Quantity:
    rule = RULES[path]
    array = check_shape(path, value, np.shape(value)).copy()
    array.flags.writeable = False
    return Quantity(
        value=array,
        unit=", ".join(si_units(rule, rule.side, joints)),
        side=rule.side,
        origin=origin,
        source=source,
    )
