"""How far the motors stray from their references: thesis 2.2.5, quantity 4."""

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.measures import rms
from ffgym.core.types import Array
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
