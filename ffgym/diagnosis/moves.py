"""When the present move of a motor began: where it turned, or started after a rest."""

import numpy as np

from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.diagnosis.regimes import DWELL, REST


def since_move(angle: Array, speed: Array, dt: float) -> tuple[Array, Array]:
    """Travel since the present move began, and how long the motor had stood before it; both as large as the angle.

    A move begins where a motor turns, and where it starts after `DWELL` or more at rest, in either direction. Shorter
    stops are turns, or none.

    Args:
        angle: of motors [rad], shape (T, ...).
        speed: of motors [rad/s], shape (T, ...).
        dt: time from one sample to the next [s].
    """
    moving = np.abs(speed) >= REST
    direction = np.sign(np.where(moving, speed, 0.0))
    before = _last(moving)  # the sample in which the motor last moved, before this one
    samples = np.arange(len(angle)).reshape(-1, *[1] * (angle.ndim - 1))
    standing = dt * (samples - 1 - before)
    came = np.where(before < 0, 0.0, np.take_along_axis(direction, np.maximum(before, 0), axis=0))
    rested = standing >= DWELL
    begins = moving & (rested | (direction != came))
    began: IntArray = np.maximum.accumulate(np.where(begins, samples, 0), axis=0)
    stood = np.where(begins & rested, standing, 0.0)
    return np.abs(angle - np.take_along_axis(angle, began, axis=0)), np.take_along_axis(stood, began, axis=0)


def _last(moving: BoolArray) -> IntArray:
    """For each sample the last one before it that is true; -1 if none is."""
    samples = np.arange(len(moving)).reshape(-1, *[1] * (moving.ndim - 1))
    upto = np.maximum.accumulate(np.where(moving, samples, -1), axis=0)
    return np.concatenate([np.full_like(upto[:1], -1), upto[:-1]])
