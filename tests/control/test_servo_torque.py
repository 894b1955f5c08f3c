"""The parts of the feedback torque: u_c, u_I, and the learning signal u_p = u_c - u_I."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from ffgym.control import servo_torque
from ffgym.robot import load_robot

SERVO = load_robot("irb4600_60_205").servo
joints = arrays(np.float64, (6,), elements=st.floats(-10, 10))


@given(error=joints, error_rate=joints, integral=joints)
def test_feedback_is_proportional_derivative_and_integral_part(error, error_rate, integral):
    torque = servo_torque(SERVO, error, error_rate, integral)
    np.testing.assert_array_equal(torque.u_i, SERVO.integral_gain * integral)
    scale = 1e-12 * np.abs(torque.u_fb).max() + 1e-9
    np.testing.assert_allclose(
        torque.u_fb, SERVO.position_gain * error + SERVO.velocity_gain * error_rate + torque.u_i, atol=scale
    )


@given(error=joints, error_rate=joints, integral=joints)
def test_u_p_does_not_depend_on_the_integral(error, error_rate, integral):
    with_integral = servo_torque(SERVO, error, error_rate, integral)
    without = servo_torque(SERVO, error, error_rate, np.zeros(6))
    np.testing.assert_array_equal(without.u_p, without.u_fb)
    np.testing.assert_allclose(with_integral.u_p, without.u_p, atol=1e-12 * np.abs(with_integral.u_i).max() + 1e-9)


def test_parts_keep_the_shape_of_a_whole_recording():
    torque = servo_torque(SERVO, np.ones((50, 6)), np.zeros((50, 6)), np.ones((50, 6)))
    assert torque.u_p.shape == torque.u_fb.shape == torque.u_i.shape == (50, 6)
