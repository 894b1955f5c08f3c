"""The reference of a motion as a table for any drive: positions, speeds, accelerations and feed-forward torques."""

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from ffgym.core.errors import check_choice
from ffgym.core.types import Array
from ffgym.paths import Reference
from ffgym.robot import RobotDescription

Sides = Literal["both", "motor", "link"]
Angles = Literal["rad", "deg", "turn"]

_PER_RADIAN = {"rad": 1.0, "deg": 180 / np.pi, "turn": 0.5 / np.pi}
"""Units of angle in a radian."""


@dataclass(frozen=True, kw_only=True)
class ReferenceForm:
    """What a drive wants to read."""

    sides: Sides = "both"
    """Side of the gearbox: motor, link (joint), or both."""
    angles: Angles = "rad"
    """Unit of angles; those of speed and acceleration follow. A sliding joint has m on the link side in any case."""

    def __post_init__(self) -> None:
        check_choice("sides", self.sides, get_args(Sides))
        check_choice("angles", self.angles, get_args(Angles))


def reference_table(reference: Reference, u_ff: Array, u_lff: Array, form: ReferenceForm) -> dict[str, Array]:
    """Columns by name, each of shape (T,): the name ends with the unit.

    Args:
        reference: the motion.
        u_ff: rigid feed-forward torque at its samples, motor side [N m], shape (T, N).
        u_lff: added feed-forward torque, likewise.
        form: sides and units.
    """
    columns = {"t [s]": reference.t}
    for side in ("link", "motor") if form.sides == "both" else (form.sides,):
        columns |= _motion(reference, side, form.angles)
        columns |= _torques(reference.robot, u_ff, u_lff, side)
    return columns


def _motion(reference: Reference, side: str, angles: str) -> dict[str, Array]:
    """Position, speed and acceleration of every joint, or of its motor."""
    motor, robot = side == "motor", reference.robot
    lengths = ["rad"] * robot.n_joints if motor else robot.kinematics.units
    values = {
        ("position", ""): reference.motor_q if motor else reference.q,
        ("velocity", "/s"): reference.motor_dq if motor else reference.dq,
        ("acceleration", "/s^2"): reference.motor_ddq if motor else reference.ddq,
    }
    columns = {}
    for (name, per_time), value in values.items():
        for j, (joint, length) in enumerate(zip(robot.joints, lengths, strict=True)):
            unit, factor = ("m", 1.0) if length == "m" else (angles, _PER_RADIAN[angles])
            columns[f"{side}.{name}.{joint} [{unit}{per_time}]"] = value[:, j] * factor
    return columns


def _torques(robot: RobotDescription, u_ff: Array, u_lff: Array, side: str) -> dict[str, Array]:
    """Feed-forward torques of every motor, or what they are behind the gearbox."""
    columns = {}
    for name, torque in {"u_ff": u_ff, "u_lff": u_lff, "u_total": u_ff + u_lff}.items():
        value = torque if side == "motor" else robot.drive.joint_torque(torque)
        for j, (joint, length) in enumerate(zip(robot.joints, robot.kinematics.units, strict=True)):
            unit = "N" if side == "link" and length == "m" else "N m"
            columns[f"{side}.{name}.{joint} [{unit}]"] = value[:, j]
    return columns
