"""Corrections of set-points: the inverse of the servo, and limits that hold at every sample."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ffgym.control import (
    CorrectionLimits,
    SetpointChannel,
    SetpointResponse,
    invert_servo,
    limit_correction,
    servo_torque,
)
from ffgym.control.corrections import difference_speeds
from ffgym.core.errors import FFGymError
from ffgym.robot import RobotDescription

DT = 0.004


def test_a_servo_gives_the_torque_in_the_middle_of_every_step(irb4600: RobotDescription) -> None:
    t = np.arange(200) * DT
    torque = np.outer(np.sin(9 * t) * np.sign(np.sin(4 * t)), irb4600.friction.static)
    correction = invert_servo(irb4600.servo, torque)
    integral = np.cumsum(correction[1:] + correction[:-1], axis=0) * DT / 2
    middle = np.pad(integral, ((1, 0), (0, 0)))[:-1] + DT / 4 * (correction[1:] + correction[:-1])
    speed = difference_speeds(correction, DT)[1:]
    given = servo_torque(irb4600.servo, (correction[1:] + correction[:-1]) / 2, speed, middle).u_fb
    np.testing.assert_allclose(given, (torque[1:] + torque[:-1]) / 2, atol=1e-9)


def test_a_servo_without_velocity_gain_is_refused(irb4600: RobotDescription) -> None:
    servo = replace(irb4600.servo, velocity_gain=np.array([0.9, 0.9, 0.0, 0.3, 0.3, 0.3]))
    with pytest.raises(FFGymError, match=r"servo.velocity_gain = .* must be > 0 on every joint"):
        invert_servo(servo, np.zeros((3, 6)))


@given(
    st.lists(st.floats(-5, 5), min_size=2, max_size=80),
    st.floats(0.01, 2.0),
    st.floats(0.1, 200.0) | st.just(np.inf),
    st.floats(1.0, 1e5) | st.just(np.inf),
)
@settings(max_examples=200, deadline=None)
def test_limited_corrections_keep_every_limit(wanted: list, size: float, rate: float, acceleration: float) -> None:
    limits = CorrectionLimits.even(1, size=size, rate=rate, acceleration=acceleration)
    found = limit_correction(limits, np.array([0.0, *wanted])[:, None], DT)
    for name, excess in limits.find_excess(found, DT).items():
        assert excess[0] < 1e-9, name


def test_a_limited_correction_comes_to_a_goal_that_stands_and_stays_there() -> None:
    limits = CorrectionLimits.even(1, size=1.0, rate=10.0, acceleration=300.0)
    found = limit_correction(limits, np.r_[0.0, np.full(200, 0.7)][:, None], DT)
    np.testing.assert_allclose(found[-50:], 0.7, atol=1e-9)
    assert found.max() <= 0.7 + 300.0 * DT**2  # no further than one step of braking


def test_corrections_within_their_limits_are_left_as_they_are() -> None:
    wanted = np.sin(np.arange(100) * DT * 10)[:, None] * 0.01
    wanted -= wanted[0]
    assert np.array_equal(limit_correction(CorrectionLimits.even(1, size=0.02), wanted, DT), wanted)


def test_limits_must_be_positive() -> None:
    with pytest.raises(FFGymError, match=r"rate of correction limits = \[0.0, 0.0\] must be > 0"):
        CorrectionLimits.even(2, rate=0.0)


def test_what_a_channel_sends_begins_at_rest_though_it_leads(irb4600: RobotDescription) -> None:
    t = np.arange(100) * irb4600.servo.control_dt
    torque = np.outer(t / t[-1], np.ones(6))
    channel = SetpointChannel(response=SetpointResponse(delay=0.02))
    sent = channel.send(irb4600.servo, torque)
    assert not sent[0].any()
    assert np.all(sent[5:] > 0)


@pytest.mark.parametrize(
    ("wanted", "dt", "message"),
    [
        (np.full((5, 2), np.nan), DT, r"wanted corrections must be finite, but entry \(0, 0\) is nan"),
        (np.zeros((2, 5)), DT, r"wanted corrections has shape \(2, 5\), must be \(any, 2\)"),
        (np.zeros((5, 2)), 0.0, r"dt = 0.0 s is out of range"),
    ],
)
def test_corrections_that_are_no_numbers_are_refused_before_limits_are_held(wanted, dt, message):
    with pytest.raises(FFGymError, match=message):
        limit_correction(CorrectionLimits.even(2, size=0.1), wanted, dt)
