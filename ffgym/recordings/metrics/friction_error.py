"""How far the torque that a law adds is from the friction it is meant to cancel."""

import numpy as np

from ffgym.core.measures import rms
from ffgym.core.types import Array, BoolArray
from ffgym.recordings import Recording


def friction_miss(recording: Recording, rows: BoolArray | None = None) -> Array:
    """RMS of friction minus added torque over RMS friction, motor side, shape (N,); 0 where there is no friction.

    Args:
        recording: of a simulation, since no machine measures its friction.
        rows: samples that count, shape (T,); None takes all but standstill.

    Raises:
        FFGymError: if the recording does not hold friction or added torque.
    """
    rows = ~recording.mask(kind="standstill") if rows is None else rows
    friction = recording.joint_array("friction.effort")[rows]
    added = recording.joint_array("compensation.effort")[rows]
    return relative_rms(friction - added, friction)


def relative_rms(difference: Array, whole: Array) -> Array:
    """RMS of `difference` over RMS of `whole`, both shape (T, N), per column, shape (N,); 0 where `whole` is zero."""
    size = rms(whole, 0)
    error = rms(difference, 0)
    return np.asarray(np.divide(error, size, out=np.zeros_like(size), where=size > 0))
