"""Residuals in which something is to be found, in noise that has been through the filter of a diagnosis."""

from dataclasses import replace

import numpy as np

from ffgym.diagnosis.residual import Residual
from ffgym.logs.preparation import LowPass
from ffgym.robot import load_robot
from tests.diagnosis.residual_samples import NOISE, made_up

ROBOT = load_robot("two_link")
SHOULDER, ELBOW = ROBOT.joints
NOISY = 3.0 * NOISE["torque"]
"""RMS of the filtered noise [N m]; the white noise of the samples adds little."""
_OVERSAMPLED = 8
"""Samples of the sensor in one row of a residual."""


def residual_with(torque=None, *, seed: int = 0) -> Residual:
    """Residual of the torques of two joints; `torque` says what is in it, from states and travel, in units of noise."""
    faults = {} if torque is None else {"torque": lambda state, travel: NOISY * torque(state, travel)}
    made = made_up(ROBOT, faults, seed=seed)
    rng = np.random.default_rng((seed, 1))
    motions = tuple(
        replace(m, measured={"torque": m.measured["torque"] + _filtered_noise(m.measured["torque"].shape, rng)})
        for m in made.motions
    )
    return replace(made, motions=motions, floor={"torque": np.hypot(made.floor["torque"], NOISY)})


def _filtered_noise(shape, rng):
    """White noise of a sensor at 1 kHz as a low-pass at 40 Hz leaves it, every eighth sample."""
    white = rng.standard_normal((_OVERSAMPLED * shape[0], shape[1]))
    filtered = LowPass(cutoff=40.0)(white, 0.001)[::_OVERSAMPLED]
    return NOISY * filtered / filtered.std()


def only(column, values):
    """Values (T,) for one joint (T, 2), nothing for the other."""
    return np.stack([values if j == column else np.zeros_like(values) for j in range(2)], axis=1)
