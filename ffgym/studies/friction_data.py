"""Friction of the LuGre model of one joint along given motor speeds, to fit networks to (thesis 6.2.2)."""

import numpy as np

from ffgym.control import DynamicLuGreEuler
from ffgym.core.errors import FFGymError, check_number, check_shape
from ffgym.core.types import Array
from ffgym.diagnosis.identification.narx import Samples
from ffgym.robot.friction import LuGreParameters

SAMPLE_TIME = 0.0005
"""T [s], thesis 6.2.2."""
N_SCORED = 2000
"""Scored samples of a record, evenly spread, so that records weigh alike; chosen: set D of Table 6.1 has 12000,
as many as the sine of the thesis."""


def lugre_samples(friction: LuGreParameters, motor_dq: Array) -> Samples:
    """Compute friction of the discretised LuGre model (6.14) of one joint along motor speeds (T,) [rad/s]."""
    motor_dq = check_shape("motor_dq", motor_dq, (None,))
    if friction.n_joints != 1:
        raise FFGymError(
            f"friction has {friction.n_joints} joints, must be that of one motor, e.g. of the robot one_axis."
        )
    torque = DynamicLuGreEuler(friction, n_substeps=1).along(motor_dq[:, None], SAMPLE_TIME)
    scored = np.arange(len(motor_dq)) % max(1, len(motor_dq) // N_SCORED) == 0
    return Samples(dt=SAMPLE_TIME, motor_dq=motor_dq[:, None], torque=torque, scored=scored, noise=np.ones(1))


def sine(amplitude: float, frequency: float, duration: float) -> Array:
    """Compute motor speeds A sin(2 pi f t) [rad/s] every SAMPLE_TIME, shape (T,), thesis (6.13) and (6.21)."""
    check_number("amplitude", amplitude, unit="rad/s")
    check_number("frequency", frequency, unit="Hz", low=0.0, open_low=True)
    check_number("duration", duration, unit="s", low=0.0, open_low=True)
    return amplitude * np.sin(2 * np.pi * frequency * SAMPLE_TIME * np.arange(round(duration / SAMPLE_TIME) + 1))
