"""Friction along speeds that were sampled rarely."""

import numpy as np
import pytest

from ffgym.diagnosis.replay.states import along_speed
from ffgym.robot.friction import LuGreParameters

_ROWS, _BETWEEN = 0.1, 200
"""Time between two rows of a log of 10 Hz [s], and fine steps in it."""


def one_joint():
    """A heavy axis, motor side: bristles give way within a hundredth of a radian."""
    values = {"coulomb": 1.3, "static": 1.3, "stribeck_velocity": 1.0, "viscous": 0.03}
    return LuGreParameters(
        **{name: np.array([value]) for name, value in values.items()},
        bristle_stiffness=np.array([162.0]),
        bristle_damping=np.array([1.6]),
    )


@pytest.mark.parametrize("after", [0.1, 0.5, 0.9])
def test_a_reversal_between_rare_rows_is_no_peak_of_torque(after):
    """Speed of a straight line that changes its sign a share of `after` of the rows' distance behind a row."""
    friction = one_joint()
    n = 9
    fine = np.linspace(0.0, n - 1.0, (n - 1) * _BETWEEN + 1)
    slip = (60.0 * (4.0 + after - fine) * _ROWS)[:, None, None]
    exact = along_speed(friction, slip, slip, _ROWS / _BETWEEN)
    rare = along_speed(friction, slip[::_BETWEEN], slip[::_BETWEEN], _ROWS)
    assert rare.torque == pytest.approx(exact.torque[::_BETWEEN], abs=0.05)
    assert rare.sign == pytest.approx(exact.sign[::_BETWEEN], abs=0.05)
