"""Records from which bristles can be told: those in which a joint turns back and is mostly between speeds."""

import numpy as np

from ffgym.diagnosis.identification.friction_data import FrictionTorque
from ffgym.diagnosis.identification.steady import constant_share

_MOVING = 0.05
"""Motor speed that a joint must reach on either side of a reversal [rad/s]: a third of the Stribeck velocity of the
thesis, well above what an encoder shows at rest."""

_SLIDES = 3.0
"""Way between two reversals, in presliding lengths f_s / sigma_0, from which on a joint slides: bristles are then bent
to 95 %. A joint that other joints only shake goes a fraction of one; the shortest of table 6.1 goes ten."""

_LEAST = 2
"""Reversals that a record must have: with one, an offset and a change of direction look alike."""

_MOSTLY = 0.2
"""Share of the time at constant speed from which a record is one of constant speeds: a sine has less than 0.02."""


def n_reversals(torque: FrictionTorque, joint: int, presliding: float) -> int:
    """Times that a joint turns back between slides.

    Args:
        torque: friction along a recording.
        joint: which joint, 0 is the first.
        presliding: how far bristles bend, f_s / sigma_0 [rad], motor side.
    """
    speed = torque.signals.motor_dq[torque.counts(joint), joint]
    speed = np.where(np.abs(speed) > _MOVING, speed, 0.0)
    moving = speed[speed != 0]
    if not len(moving):
        return 0
    stroke = np.concatenate([[0], np.cumsum(np.diff(np.sign(moving)) != 0)])
    way = np.bincount(stroke, np.abs(moving)) * torque.signals.dt
    slides = way > _SLIDES * presliding
    return int(np.count_nonzero(slides[1:] & slides[:-1]))


def reverses(torque: FrictionTorque, joint: int, presliding: float) -> bool:
    """Whether a record tells a joint's bristles; arguments as `n_reversals`."""
    return n_reversals(torque, joint, presliding) >= _LEAST and constant_share(torque, joint) < _MOSTLY
