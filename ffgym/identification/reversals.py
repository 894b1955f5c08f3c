"""Records from which bristles can be told: those in which a joint turns back and is mostly between speeds."""

import numpy as np

from ffgym.identification.friction_torque import FrictionTorque
from ffgym.identification.steady import constant_share

_MOVING = 0.05
"""Motor speed that a joint must reach on either side of a reversal [rad/s]: a third of the Stribeck velocity of the
thesis, well above what an encoder shows at rest."""

_LEAST = 2
"""Reversals that a record must have: with one, an offset and a change of direction look alike."""

_MOSTLY = 0.2
"""Share of the time at constant speed from which a record is one of constant speeds: a sine has less than 0.02."""


def n_reversals(torque: FrictionTorque, joint: int) -> int:
    """Times that a joint turns back."""
    speed = torque.signals.motor_dq[torque.valid, joint]
    moving = speed[np.abs(speed) > _MOVING]
    return int(np.count_nonzero(np.diff(np.sign(moving)))) if len(moving) else 0


def reverses(torque: FrictionTorque, joint: int) -> bool:
    """Whether a record tells a joint's bristles."""
    return n_reversals(torque, joint) >= _LEAST and constant_share(torque, joint) < _MOSTLY
