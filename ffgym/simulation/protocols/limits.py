"""Motions within the torques that the drives can give."""

from dataclasses import replace

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.paths import JointPath, Reference, joint_reference
from ffgym.robot import RigidArm, motor_torque
from ffgym.simulation.protocols.stage import Stage

MOST_TORQUE = 0.9
"""Largest share of peak torque that a rigid arm may take on a motion; chosen: the rest is for feedback and what the
description does not know."""

LARGE_TORQUE = 0.5
"""Share of peak torque up to which motions are enlarged that want to be large; chosen: half is left for a payload."""

_COARSE = 0.01
"""Time between the instants at which torques are examined [s]; chosen: those of planned motions change within 0.1 s."""

_CLOSE = 0.004
"""How closely the size of a motion is found."""


def torque_use(arm: RigidArm, reference: Reference) -> float:
    """Largest share of peak torque that a rigid arm takes on a motion, friction included."""
    every = _stride(reference)
    return _use(arm, reference.q[::every], reference.dq[::every], reference.ddq[::every])


def _stride(motion: Reference | JointPath) -> int:
    """Samples from one instant that is examined to the next."""
    return max(1, round(_COARSE / float(motion.t[1])))


def _use(arm: RigidArm, q: Array, dq: Array, ddq: Array) -> float:
    torque = motor_torque(arm, q, dq, ddq).total
    return float(np.max(np.abs(torque) / arm.robot.drive.peak_torque))


def check_torque(arm: RigidArm, reference: Reference) -> None:
    """Check that the drives can give what a motion takes.

    Raises:
        FFGymError: if a rigid arm would take more than MOST_TORQUE of a drive's peak torque.
    """
    use = torque_use(arm, reference)
    if use > MOST_TORQUE:
        raise FFGymError(
            f"motion {reference.name!r} takes {use:.0%} of the peak torque of a drive, must be at most "
            f"{MOST_TORQUE:.0%}. Ask for less speed or way, or check the description with ffgym robot check."
        )


def shrunk(stage: Stage, path: JointPath) -> Reference:
    """A motion, made smaller about where it starts until it keeps the tool near and takes at most LARGE_TORQUE.

    Raises:
        FFGymError: if even the smallest takes more.
    """
    arm = stage.arm
    every = _stride(path)
    way, dq, ddq = path.q[::every] - path.q[0], path.dq[::every], path.ddq[::every]

    def fits(size: float) -> bool:
        q = path.q[0] + size * way
        return bool(stage.keeps_tool_near(q).all()) and _use(arm, q, size * dq, size * ddq) <= LARGE_TORQUE

    low, high = 0.0, 1.0
    if fits(high):
        low = high
    while high - low > _CLOSE:
        middle = (low + high) / 2
        low, high = (middle, high) if fits(middle) else (low, middle)
    if low == 0.0:
        raise FFGymError(
            f"no motion, however small, takes at most {LARGE_TORQUE:.0%} of the drives' peak torque and keeps the tool "
            f"near where it rests. Choose another home, or check the description with ffgym robot check."
        )
    q = path.q[0] + low * (path.q - path.q[0])
    return joint_reference(arm.robot, replace(path, q=q, dq=low * path.dq, ddq=low * path.ddq))
