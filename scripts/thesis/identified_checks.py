"""What claims about identified friction are decided by: thesis 6.1."""

from collections.abc import Iterable

import numpy as np

from ffgym.robot.friction import LuGreParameters
from scripts.thesis.axis_measures import BEND
from scripts.thesis.claims import CLEAR, ROUGH, ZERO, Check
from scripts.thesis.laboratory import Laboratory
from scripts.thesis.measured_friction import MeasuredFriction


def shares(measured: MeasuredFriction, friction: LuGreParameters, numbers: Iterable[int]) -> dict[int, float]:
    """RMS error over RMS friction of records, by number."""
    errors = measured.errors(friction)
    return {number: errors[number].rms_error / errors[number].rms_friction for number in numbers}


def good_fit(laboratory: Laboratory, numbers: Iterable[int]) -> list[Check]:
    """Whether the identified model is a reasonable approximation of records."""
    measured = laboratory.joint_1
    return [
        Check(where=f"record {number}, RMS error / RMS friction", value=share, limit=ROUGH)
        for number, share in shares(measured, measured.found.friction, numbers).items()
    ]


def matches(laboratory: Laboratory) -> list[Check]:
    """Whether the points at constant speed lie on the identified curve; nothing to compare if there are too few."""
    measured = laboratory.joint_1
    fit = measured.found.joints[measured.index].stribeck
    if fit is None:
        return []
    _, friction, _ = fit.data.levels()
    size = float(np.sqrt(np.mean(friction**2)))
    return [Check(where="RMS distance of the points from the curve [N m]", value=fit.rms_error, limit=ZERO * size)]


def has_a_loop(laboratory: Laboratory, number: int) -> list[Check]:
    """Whether the friction of a record differs between rising and falling speed."""
    measured = laboratory.joint_1
    torque, joint = measured.records[number], measured.index
    speed = torque.signals.motor_dq[:, joint]
    rises, slow = np.gradient(speed) > 0, torque.valid & (np.abs(speed) < BEND)
    friction = torque.friction[:, joint]
    apart = float(abs(friction[slow & rises].mean() - friction[slow & ~rises].mean()))
    size = float(np.sqrt(np.mean(friction[torque.valid] ** 2)))
    where = f"{ZERO:.0%} of the RMS friction against mean while speed rises less falls, below {BEND:g} rad/s [N m]"
    return [Check(where=where, value=ZERO * size, limit=apart)]


def original_is_worse(laboratory: Laboratory, numbers: Iterable[int]) -> list[Check]:
    """Whether the identified model is clearly better than the original one on records."""
    measured = laboratory.joint_1
    new, old = measured.errors(measured.found.friction), measured.errors(measured.old)
    return [
        Check(
            where=f"record {number}, RMS error, identified against {1 - CLEAR:.0%} of original [N m]",
            value=new[number].rms_error,
            limit=(1 - CLEAR) * old[number].rms_error,
        )
        for number in numbers
    ]


def neither(laboratory: Laboratory, number: int) -> list[Check]:
    """Whether both models are no reasonable approximation of a record."""
    measured = laboratory.joint_1
    return [
        Check(
            where=f"record {number}, a rough approximation against RMS error / RMS friction, {name}",
            value=ROUGH,
            limit=shares(measured, friction, [number])[number],
        )
        for name, friction in {"identified": measured.found.friction, "original": measured.old}.items()
    ]
