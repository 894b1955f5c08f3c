"""Random joint motions: every episode its own, at rest at both ends, within what the robot can do."""

import gymnasium as gym
import numpy as np
import pytest

from ffgym.envs.joint_motion import PEAK_SPEEDS, RandomTasks
from tests.envs.env_samples import JOINTS


@pytest.fixture(scope="module")
def tasks(irb4600):
    return RandomTasks(irb4600, duration=2.0, peak_speeds=PEAK_SPEEDS, spread=0.3)


@pytest.fixture(scope="module")
def motions(tasks):
    rng = np.random.default_rng(0)
    return [tasks.draw(rng, {}) for _ in range(60)]


def test_each_motor_reaches_the_peak_speed_that_was_drawn_for_it(motions):
    for motion in motions:
        peak = np.abs(motion.reference.motor_dq).max(axis=0)
        np.testing.assert_allclose(peak, motion.task["peak_speed"], rtol=1e-6)
    drawn = np.array([motion.task["peak_speed"] for motion in motions])
    assert drawn.min() >= PEAK_SPEEDS[0]
    assert drawn.max() <= PEAK_SPEEDS[1]
    middle = np.sqrt(np.prod(PEAK_SPEEDS))  # of the logarithms
    assert 0.4 < np.mean(drawn < middle) < 0.6
    assert np.abs(np.corrcoef(np.log(drawn).T) - np.eye(6)).max() < 0.5


def test_a_motion_starts_and_ends_at_rest_at_its_centre(motions):
    for motion in motions:
        reference = motion.reference
        for row in (0, 10, -10, -1):
            np.testing.assert_allclose(reference.q[row], motion.task["centre"], atol=1e-9)
            np.testing.assert_allclose(reference.dq[row], 0.0, atol=1e-9)
            np.testing.assert_allclose(reference.ddq[row], 0.0, atol=1e-9)
        assert reference.duration == pytest.approx(2.0)


def test_motions_stay_near_home_within_the_joint_limits(motions, irb4600):
    for motion in motions:
        assert np.abs(np.array(motion.task["centre"]) - irb4600.work_area.home).max() <= 0.3
        assert (motion.reference.q >= irb4600.kinematics.range[:, 0]).all()
        assert (motion.reference.q <= irb4600.kinematics.range[:, 1]).all()


def test_a_wide_spread_is_kept_away_from_the_limits(irb4600):
    wide = RandomTasks(irb4600, duration=1.0, peak_speeds=(1.0, 2.0), spread=100.0)
    limits = irb4600.kinematics.range
    rng = np.random.default_rng(0)
    centres = np.array([wide.draw(rng, {}).task["centre"] for _ in range(20)])
    share = (centres - limits[:, 0]) / np.diff(limits, axis=1)[:, 0]
    np.testing.assert_allclose([share.min(), share.max()], [0.1, 0.9], atol=1e-9)


def test_position_speed_and_acceleration_belong_together(motions):
    reference = motions[3].reference
    dt = reference.t[1]
    largest = np.abs(reference.dq).max(axis=0)
    np.testing.assert_allclose(np.gradient(reference.q, dt, axis=0) / largest, reference.dq / largest, atol=0.02)
    largest = np.abs(reference.ddq).max(axis=0)
    np.testing.assert_allclose(np.gradient(reference.dq, dt, axis=0) / largest, reference.ddq / largest, atol=0.05)


def test_options_fix_centre_and_peak_speed_and_leave_the_sines_to_the_seed(tasks, irb4600):
    home = irb4600.work_area.home
    free, fixed = (
        tasks.draw(np.random.default_rng(4), options) for options in ({}, {"centre": home, "peak_speed": 5.0})
    )
    np.testing.assert_allclose(fixed.reference.q[0], home, atol=1e-12)
    np.testing.assert_allclose(np.abs(fixed.reference.motor_dq).max(axis=0), 5.0, rtol=1e-6)
    shape = [m.reference.motor_dq / np.abs(m.reference.motor_dq).max(axis=0) for m in (free, fixed)]
    np.testing.assert_allclose(*shape, atol=1e-9)
    each = tasks.draw(np.random.default_rng(4), {"peak_speed": [1, 2, 3, 4, 5, 6]})
    np.testing.assert_allclose(np.abs(each.reference.motor_dq).max(axis=0), [1, 2, 3, 4, 5, 6], rtol=1e-6)
    still = tasks.draw(np.random.default_rng(4), {"peak_speed": 0.0})
    assert not still.reference.dq.any()


def test_no_two_episodes_are_alike_and_a_seed_repeats_them():
    env = gym.make_vec(JOINTS, num_envs=3, horizon=1, autoreset_mode="SameStep", duration=1.0)
    runs = []
    for _ in range(2):
        env.reset(seed=1)
        centres = []
        for _ in range(4):
            centres += [motion.task["centre"][0] for motion in env.core.motions]
            env.step(np.zeros((3, 6)))
        runs.append(centres)
    assert runs[0] == runs[1]
    assert len(set(runs[0])) == 12


def test_a_robot_without_work_area_moves_about_zero():
    env = gym.make(JOINTS, robot="one_axis", spread=0.0)
    env.reset(seed=0)
    assert env.unwrapped.core.motions[0].task["centre"] == [0.0]
