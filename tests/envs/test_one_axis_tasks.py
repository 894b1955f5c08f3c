"""The one-axis test: sines of one motor."""

import gymnasium as gym
import numpy as np
import pytest

from ffgym.envs.one_axis import SineTasks
from tests.envs.env_samples import ONE_AXIS


@pytest.fixture(scope="module")
def tasks(one_axis):
    return SineTasks(one_axis, frequencies=(1.0, 3.0), amplitude=0.7, duration=2.0)


def test_the_motor_follows_a_sine_of_the_frequency_and_amplitude(tasks):
    reference = tasks.draw(np.random.default_rng(0), {"frequency": 2.5, "amplitude": 0.3}).reference
    omega = 2 * np.pi * 2.5
    np.testing.assert_allclose(reference.q[:, 0], 0.3 * np.sin(omega * reference.t), atol=1e-12)
    np.testing.assert_allclose(reference.dq[:, 0], 0.3 * omega * np.cos(omega * reference.t), atol=1e-12)
    assert reference.duration == pytest.approx(2.0)


def test_frequencies_are_drawn_evenly_or_run_one_after_the_other(tasks):
    rng = np.random.default_rng(0)
    drawn = [tasks.draw(rng, {}).task for _ in range(200)]
    assert {task["amplitude"] for task in drawn} == {0.7}
    counts = [sum(task["frequency"] == f for task in drawn) for f in (1.0, 3.0)]
    assert sum(counts) == 200
    assert min(counts) > 65
    assert tasks.list_options() == [{"frequency": 1.0}, {"frequency": 3.0}]
    env = gym.make_vec(ONE_AXIS, num_envs=3, sampling="sequence")
    env.reset(seed=0)
    assert [motion.task["frequency"] for motion in env.core.motions] == [1.0, 3.0, 1.0]
    env.reset()
    assert [motion.task["frequency"] for motion in env.core.motions] == [3.0, 1.0, 3.0]


def test_one_number_is_one_frequency():
    env = gym.make(ONE_AXIS, frequencies=2.0)
    env.reset(seed=0)
    assert env.unwrapped.core.motions[0].task == {"frequency": 2.0, "amplitude": 1.0}


def test_an_episode_lasts_as_long_as_the_sine_and_starts_at_full_speed():
    env = gym.make(ONE_AXIS, duration=0.1)
    observation, info = env.reset(seed=0, options={"frequency": 1.0, "amplitude": 1.0})
    assert info["time"] == 0.0
    assert info["phase"] == "motion"
    speed = env.unwrapped.observation_layout.read(observation, "reference_velocity")
    np.testing.assert_allclose(speed, 2 * np.pi, rtol=1e-9)
    np.testing.assert_allclose(env.unwrapped.observation_layout.read(observation, "error_rate"), 0.0, atol=1e-9)
    ends = [env.step([0.0])[3] for _ in range(25)]
    assert ends == [False] * 24 + [True]


def test_a_robot_without_tool_tells_no_path_error():
    _, info = gym.make(ONE_AXIS).reset(seed=0)
    assert not {"tcp", "path_error"} & set(info)
