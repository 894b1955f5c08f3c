"""Entries that follow from others by a rule of thumb; each says which, so that a better number can replace it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ffgym.core.types import Array
from ffgym.robot.dynamics.arm import RigidArm
from ffgym.robot.reading.draft import RobotDraft
from ffgym.robot.reading.rules import RULES

STATIC_SHARE = 1.05
"""Breakaway over Coulomb torque; the thesis' joint has 0.5634 / 0.5367."""
STRIBECK_VELOCITY = 0.15
"""Motor speed [rad/s]; thesis 6.1.1."""
PRESLIDING = 7.67e-3
"""Coulomb torque over bristle stiffness [rad] of the motor; the thesis' joint has 0.5367 / 69.9787."""
BRISTLE_TIME = 9.65e-3
"""Bristle damping over stiffness [s]; the thesis' joint has 0.6753 / 69.9787."""
DAMPING_TIME = 8e-4
"""Joint damping over stiffness [s]; Moberg's benchmark has 5.5e-4 to 1.0e-3, Manutec r3 1.2e-4 to 1.25e-3."""
SPEED_LOOP, POSITION_LOOP, INTEGRAL_TIME = 90.0, 24.73, 0.25
"""K_v over inertia [1/s], K_p over K_v [1/s] without the integral's share, and the integral's time [s]: the only
servo gains of an ABB drive that were found published (docs/robots/irb4600_60_205.md, prior of the servo)."""
CONTROL_DT = 4e-3
"""Sample time of references [s]; thesis 4.2."""
LONGEST_STEP = 2.5e-4
"""Physics step [s] at which the built-in robot has converged (docs/physics.md)."""
ENCODER_BITS = 16.0
"""Resolution of a usual resolver or encoder."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Proposal:
    """A number for an entry of a description, in SI units."""

    path: str
    value: Array
    source: str
    origin: str = "chosen"
    side: str | None = None
    """Side of the gearbox on which it is given."""


class _Thumb(NamedTuple):
    """A rule of thumb."""

    needs: tuple[str, ...]
    value: Callable[[Mapping[str, Array], int], Array]
    """Function from known entries and the number of joints."""
    source: str


_THUMBS: Mapping[str, _Thumb] = {
    "drive.joint_damping": _Thumb(
        ("drive.joint_stiffness",),
        lambda known, _: np.where(
            np.isinf(known["drive.joint_stiffness"]), 0.0, DAMPING_TIME * known["drive.joint_stiffness"]
        ),
        f"{DAMPING_TIME:g} s x stiffness, as published benchmark robots; 0 for a rigid joint",
    ),
    "friction.static": _Thumb(
        ("friction.coulomb",),
        lambda known, _: STATIC_SHARE * known["friction.coulomb"],
        f"{STATIC_SHARE:g} x coulomb, as the joint of the thesis",
    ),
    "friction.stribeck_velocity": _Thumb(
        (), lambda _, n: np.full(n, STRIBECK_VELOCITY), f"{STRIBECK_VELOCITY:g} rad/s, as the joint of the thesis"
    ),
    "friction.bristle_stiffness": _Thumb(
        ("friction.coulomb",),
        lambda known, _: known["friction.coulomb"] / PRESLIDING,
        f"coulomb / {PRESLIDING * 1e3:g} mrad of presliding motion of the motor, as the joint of the thesis",
    ),
    "friction.bristle_damping": _Thumb(
        ("friction.bristle_stiffness",),
        lambda known, _: BRISTLE_TIME * known["friction.bristle_stiffness"],
        f"{BRISTLE_TIME * 1e3:g} ms x bristle_stiffness, as the joint of the thesis",
    ),
    "servo.control_dt": _Thumb((), lambda _, n: np.array(CONTROL_DT), "4 ms, as the robot of the thesis"),
    "sensors.encoder_bits": _Thumb(
        (), lambda _, n: np.array(ENCODER_BITS), "a usual resolver or encoder; acts on measured recordings only"
    ),
    "simulation.physics_dt": _Thumb(
        ("servo.control_dt",),
        lambda known, _: known["servo.control_dt"] / np.ceil(known["servo.control_dt"] / LONGEST_STEP - 1e-9),
        f"largest whole part of control_dt up to {LONGEST_STEP * 1e3:g} ms, where the built-in robot has converged",
    ),
}
"""Rules of thumb, ordered so that each comes after those that it needs."""


def propose(draft: RobotDraft) -> list[Proposal]:
    """Propose numbers for entries that the draft lacks and that follow from those it has, or from one another."""
    known = {path: quantity.value for path, quantity in draft.quantities.items()}
    lacking = set(draft.missing) - set(draft.waiting)
    found = []
    for path, thumb in _THUMBS.items():
        if path in lacking and all(need in known for need in thumb.needs):
            known[path] = thumb.value(known, len(draft.joints))
            found.append(Proposal(path=path, value=known[path], source=thumb.source, side=RULES[path].side))
    return found + _servo_gains(draft, lacking)


def _servo_gains(draft: RobotDraft, lacking: set[str]) -> list[Proposal]:
    """Propose servo gains by the inertia that each motor turns at home."""
    if not draft.can("motor_torque"):
        return []
    robot = draft.description_for("motor_torque")
    home = np.clip(0.0, *robot.kinematics.range.T) if robot.work_area is None else robot.work_area.home
    drive = robot.drive
    links = drive.inverse.T @ RigidArm(robot).mass_matrix(home[None])[0] @ drive.inverse
    speed_gain = SPEED_LOOP * (drive.rotor_inertia + np.diag(links))
    position, integral = POSITION_LOOP + 1 / INTEGRAL_TIME, POSITION_LOOP / INTEGRAL_TIME
    rules = {
        "servo.position_gain": (position * speed_gain, f"{position:g} 1/s x velocity_gain"),
        "servo.velocity_gain": (speed_gain, f"{SPEED_LOOP:g} 1/s x inertia of rotor and links at the motor, at home"),
        "servo.integral_gain": (integral * speed_gain, f"{integral:g} 1/s^2 x velocity_gain"),
    }
    return [
        Proposal(path=path, value=value, source=f"{source}: published gains of an ABB drive", side=RULES[path].side)
        for path, (value, source) in rules.items()
        if path in lacking
    ]
