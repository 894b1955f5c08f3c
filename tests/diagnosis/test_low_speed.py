"""Rows that a model without friction at low speed is not judged by."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.diagnosis.log import log_of
from ffgym.diagnosis.low_speed import SLOW, judged_rows, knows_low_speed
from ffgym.robot import load_robot
from tests.identification.rigid_body.recorded_arms import recorded, rigid, swing


@pytest.fixture(scope="module")
def two_link():
    return rigid(load_robot("two_link"))


@pytest.fixture(scope="module")
def recording(two_link):
    return recorded(two_link, swing(two_link, 1, duration=12.0), segment="swing")


def without_peak(robot, *joints):
    """The robot with plain Coulomb and viscous friction on some joints."""
    friction = robot.friction
    static = friction.static.copy()
    static[list(joints)] = friction.coulomb[list(joints)]
    return replace(robot, friction=replace(friction, static=static))


def test_a_breakaway_peak_is_knowledge_of_low_speed(two_link):
    assert knows_low_speed(two_link).all()
    np.testing.assert_array_equal(knows_low_speed(without_peak(two_link, 1)), [True, False])


def test_all_rows_count_where_low_speed_is_described(two_link, recording):
    assert judged_rows(log_of(two_link, [recording])).all()


def test_rows_in_reach_of_a_slow_sample_do_not_count_for_that_motor_alone(two_link, recording):
    log = log_of(without_peak(two_link, 1), [recording])
    judged, sampling = judged_rows(log), log.sampling
    assert judged[..., 0].all()
    slow = np.abs(log.dq[:, 0, 1]) < SLOW * two_link.kinematics.max_speed[1]
    for row, sample in enumerate(sampling.at):
        reach = slow[max(0, sample - sampling.half_length) : sample + sampling.half_length + 1]
        assert judged[row, 0, 1] == (not reach.any())
    assert 0.5 < judged[..., 1].mean() < 1.0
