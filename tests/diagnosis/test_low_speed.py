"""Rows that a model without friction at low speed is not judged by."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.diagnosis.log import log_of
from ffgym.diagnosis.measured import SLOW, judged_rows, knows_low_speed, residual_of
from ffgym.diagnosis.patterns.rows import rows_of
from ffgym.diagnosis.replay import replay
from ffgym.robot import load_robot
from ffgym.simulation.plant import Machine
from tests.diagnosis.identification.rigid_body.recorded_arms import recorded, rigid, swing


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


def test_what_no_model_is_judged_by_is_no_pattern_and_not_in_pictures(two_link, recording):
    robot = without_peak(two_link, 1)
    log = log_of(robot, [recording])
    judged = judged_rows(log)
    rest = np.where(judged, 0.5, 1e6) + 0.01 * np.sin(np.arange(len(judged)))[:, None, None]
    residual = residual_of(log, replay(log, Machine.of(robot)), {"torque": rest}, {"torque": np.ones((1, 2))})
    motion, rows = residual.motions[0], rows_of(residual, "torque", np.random.default_rng(0))
    valid = motion.valid
    np.testing.assert_array_equal(np.isnan(motion.residual["torque"])[valid], ~judged[valid, 0])
    assert np.abs(rows.values).max() < 0.03
    assert rows.noise[0, 1] == np.count_nonzero(judged[valid, 0, 1])
