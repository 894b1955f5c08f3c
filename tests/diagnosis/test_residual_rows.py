"""What motors were doing at a row, and which rows count."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ffgym.diagnosis.log import assemble_log
from ffgym.diagnosis.patterns.rows import collect_pattern_rows
from ffgym.diagnosis.replay import replay
from ffgym.diagnosis.residual_rows import (
    _detrend,
    assemble_residual,
    describes_low_speed,
    find_predictable_rows,
    measure_moves,
)
from ffgym.diagnosis.settings import settings
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
    assert describes_low_speed(two_link).all()
    np.testing.assert_array_equal(describes_low_speed(without_peak(two_link, 1)), [True, False])


def test_all_rows_count_where_low_speed_is_described(two_link, recording):
    assert find_predictable_rows(assemble_log(two_link, [recording])).all()


def test_rows_in_reach_of_a_slow_sample_do_not_count_for_that_motor_alone(two_link, recording):
    log = assemble_log(without_peak(two_link, 1), [recording])
    judged, sampling = find_predictable_rows(log), log.sampling
    assert judged[..., 0].all()
    slow = np.abs(log.dq[:, 0, 1]) < settings().replay.low_speed * two_link.kinematics.max_speed[1]
    for row, sample in enumerate(sampling.at):
        reach = slow[max(0, sample - sampling.half_length) : sample + sampling.half_length + 1]
        assert judged[row, 0, 1] == (not reach.any())
    assert 0.5 < judged[..., 1].mean() < 1.0


def test_what_no_model_is_judged_by_is_no_pattern_and_not_in_pictures(two_link, recording):
    robot = without_peak(two_link, 1)
    log = assemble_log(robot, [recording])
    judged = find_predictable_rows(log)
    rest = np.where(judged, 0.5, 1e6) + 0.01 * np.sin(np.arange(len(judged)))[:, None, None]
    residual = assemble_residual(log, replay(log, Machine.of(robot)), {"torque": rest}, {"torque": np.ones((1, 2))})
    motion, rows = residual.motions[0], collect_pattern_rows(residual, "torque", np.random.default_rng(0))
    valid = motion.valid
    np.testing.assert_array_equal(np.isnan(motion.residual["torque"])[valid], ~judged[valid, 0])
    assert np.abs(rows.values).max() < 0.03
    assert rows.noise[0, 1] == np.count_nonzero(judged[valid, 0, 1])


DT = 0.01


def moved(*pieces):
    """Angle and speed (T, 1) of pieces (speed, duration)."""
    speed = np.concatenate([np.full(round(duration / DT), v) for v, duration in pieces])[:, None]
    return np.cumsum(speed, axis=0) * DT, speed


def test_a_restart_in_the_same_direction_begins_anew_and_knows_its_rest():
    travel, stood = measure_moves(*moved((1.0, 1.0), (0.0, 0.5), (1.0, 1.0)), DT)
    assert travel[99] == pytest.approx(0.99)
    assert travel[150] == 0.0
    assert travel[-1] == pytest.approx(0.99)
    assert stood[99] == 0.0
    np.testing.assert_allclose(stood[150:], 0.5)


def test_a_motor_that_stops_to_turn_begins_anew_and_has_not_stood():
    travel, stood = measure_moves(*moved((1.0, 1.0), (0.0, settings().patterns.dwell / 2), (-1.0, 1.0)), DT)
    assert travel[-1] == pytest.approx(0.99)
    assert np.all(stood == 0.0)


def test_a_moment_of_standing_within_a_move_changes_nothing():
    travel, stood = measure_moves(*moved((1.0, 1.0), (0.0, settings().patterns.dwell / 2), (1.0, 1.0)), DT)
    assert travel[-1] == pytest.approx(1.99)
    assert np.all(stood == 0.0)


def test_a_record_that_begins_at_rest_counts_that_rest():
    travel, stood = measure_moves(*moved((0.0, 1.0), (-2.0, 0.5)), DT)
    assert travel[-1] == pytest.approx(0.98)
    np.testing.assert_allclose(stood[100:], 1.0)
    assert np.all(stood[:100] == 0.0)


@given(
    st.lists(
        st.tuples(st.sampled_from([-3.0, -1.0, 0.0, 0.9 * settings().patterns.rest, 1.0]), st.integers(1, 60)),
        min_size=1,
    )
)
def test_what_a_loop_over_samples_finds_is_found(pieces):
    angle, speed = moved(*((v, n * DT) for v, n in pieces))
    travel, stood = measure_moves(np.hstack([angle, -2 * angle]), np.hstack([speed, -2 * speed]), DT)
    began, last, still, before = 0, 0.0, 0, 0.0
    for k, v in enumerate(speed[:, 0]):
        if abs(v) < settings().patterns.rest:
            still += 1
        else:
            if np.sign(v) != last or still * DT >= settings().patterns.dwell:
                began, before = k, still * DT if still * DT >= settings().patterns.dwell else 0.0
            last, still = np.sign(v), 0
        assert travel[k, 0] == pytest.approx(abs(angle[k, 0] - angle[began, 0]))
        assert stood[k, 0] == pytest.approx(before)


@pytest.mark.parametrize("slope", [False, True])
def test_means_and_slopes_of_rows_that_count_are_taken_off_and_nothing_else(slope):
    rng, time = np.random.default_rng(0), np.arange(60.0)
    valid = np.zeros((60, 2), dtype=bool)
    valid[5:55, 0], valid[10:30, 1] = True, True
    wave = rng.normal(size=(60, 2, 3))
    for m in range(2):
        own = valid[:, m]
        for k in range(3):
            wave[own, m, k] -= np.polyval(np.polyfit(time[own], wave[own, m, k], 1), time[own])
    drift = np.array([0.02, -0.5])[:, None] * (time[:, None, None] - 20.0) if slope else 0.0
    rest = _detrend(wave + 3.0 + drift, valid, slope=slope)
    np.testing.assert_allclose(rest[valid], wave[valid], atol=1e-12)


def test_a_slope_stays_where_only_the_mean_is_unknown():
    rows = np.linspace(-1.0, 1.0, 41)[:, None, None]
    np.testing.assert_allclose(_detrend(rows, np.ones((41, 1), dtype=bool), slope=False), rows, atol=1e-12)
