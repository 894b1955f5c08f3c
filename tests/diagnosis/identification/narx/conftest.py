"""Networks with random weights, and the motions that they are driven by."""

import numpy as np
import pytest

from ffgym.diagnosis.identification.narx import Samples
from tests.narx_samples import random_network


@pytest.fixture
def network():
    """Function that makes a network of two motors with random weights."""
    return random_network


@pytest.fixture
def sweep():
    """Function that gives motor speeds: a sine of another frequency on each motor."""

    def make(rows=600, n=2):
        t = 0.004 * np.arange(rows)
        return np.stack([2 * np.sin(2 * np.pi * (0.5 + 0.2 * j) * t) for j in range(n)], axis=-1)

    return make


@pytest.fixture
def samples_of():
    """Function that makes samples of motor speeds and torques."""

    def make(motor_dq, torque, dt=0.004):
        rows, n = motor_dq.shape
        scored = np.ones(rows, dtype=np.bool_)
        return Samples(dt=dt, motor_dq=motor_dq, torque=torque, scored=scored, noise=np.full(n, 0.01))

    return make
