"""Environments on robots of other kinds: reversing gearboxes, coupled axes, slides, no tool, no looks."""

from dataclasses import replace

import gymnasium as gym
import numpy as np
import pytest

import ffgym  # noqa: F401  (registers the environments)
from ffgym.core.errors import FFGymError
from ffgym.robot import builtin_robots, load_robot


def coupled(robot):
    """The robot with a reversing gearbox on joint 2, and wrist motors that turn with the joints before them."""
    ratio = robot.drive.gear_ratio * np.array([1, -1, 1, 1, 1, 1])
    coupling = np.zeros((6, 6))
    coupling[4, 3], coupling[5, 3], coupling[5, 4] = 1.0, -1.2, 0.7
    return replace(robot, drive=replace(robot.drive, gear_ratio=ratio, coupling=coupling))


def test_joint_positions_are_read_behind_the_gearbox_whatever_its_sign_and_coupling(irb4600):
    env = gym.make("ffgym/JointMotion-v0", robot=coupled(irb4600), preview=2).unwrapped
    observation, _ = env.reset(seed=0)
    for k in range(20):
        reference = env.core.motions[0].reference
        for ahead in range(3):
            seen = env.observation_layout.read(observation, "reference_position", ahead_by=ahead)
            np.testing.assert_allclose(seen, reference.q[k + ahead], atol=1e-12)
        seen = env.observation_layout.read(observation, "reference_velocity")
        np.testing.assert_allclose(seen, reference.motor_dq[k], atol=1e-12)
        observation, *_ = env.step(np.zeros(6))


def test_the_position_of_a_slide_is_in_metres_and_scaled_by_its_range():
    robot = load_robot("ball_screw")
    env = gym.make("ffgym/JointMotion-v0", robot=robot, spread=0.0).unwrapped
    entry = env.observation_layout["reference_position"]
    assert (entry.unit, entry.side) == ("m", "link")
    np.testing.assert_allclose(entry.scale, np.ptp(robot.kinematics.range, axis=1) / 2)
    observation, _ = env.reset(seed=0)
    q = env.core.motions[0].reference.q
    np.testing.assert_allclose(env.observation_layout.read(observation, "reference_position"), q[0], atol=1e-15)


@pytest.mark.parametrize("name", builtin_robots())
def test_every_robot_moves_at_random(name):
    env = gym.make("ffgym/JointMotion-v0", robot=name, duration=1.0)
    env.reset(seed=0)
    ended, rewards = False, []
    while not ended:
        _, reward, terminated, ended, _ = env.step(np.zeros(env.action_space.shape))
        rewards.append(reward)
        assert not terminated
    assert np.isfinite(rewards).all()
    assert min(rewards) < 0


def test_circles_need_a_work_area():
    with pytest.raises(FFGymError, match="has no work area for circles"):
        gym.make("ffgym/CirclePath-v0", robot="ball_screw")


def test_the_sine_test_needs_one_joint():
    with pytest.raises(FFGymError, match="has 6 joints; the sine test is for one"):
        gym.make("ffgym/OneAxis-v0", robot="irb4600_60_205")
