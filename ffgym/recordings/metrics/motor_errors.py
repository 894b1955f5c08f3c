"""How far the motors stray from their references: thesis 2.2.5, quantity 4."""

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.measures import rms
from ffgym.core.types import Array, BoolArray
from ffgym.recordings import Recording


def motor_error(recording: Recording) -> Array:
    """Motor position error e = reference - measured, motor side [rad], shape (T, N)."""
    error = recording.joint_array("reference.position") - recording.joint_array("motor.position")
    header = recording.header
    if header.position_side == "motor":
        return error
    motor = error * np.asarray(header.gear_ratio)
    if header.coupling is not None:
        motor += (error[:, None, :] * np.asarray(header.coupling)).sum(axis=2)
    return motor


def motor_error_rms(recording: Recording) -> Array:
    """RMS of the motor position error, motor side [rad], shape (N,); standstill does not count (thesis 4.3.2).

    Raises:
        FFGymError: if the recording is nothing but standstill.
    """
    moving = ~recording.mask(kind="standstill")
    if not moving.any():
        raise FFGymError(
            f"Recording {recording.header.segment!r} is all standstill, so it has no motor error to score."
        )
    return rms(motor_error(recording)[moving], 0)


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
    return np.asarray(np.divide(rms(difference, 0), size, out=np.zeros_like(size), where=size > 0))
