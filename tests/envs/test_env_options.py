"""What `reset(options=...)` fixes: one episode, of every sub-environment or of each its own."""

from dataclasses import replace
from importlib import resources

import gymnasium as gym
import numpy as np
import pytest

from ffgym.robot import load_robot
from ffgym.simulation.plant import LogUniform, PlantDistribution, Uniform
from tests.envs.env_samples import CIRCLE, JOINTS, ONE_AXIS, plant_state

SAME_STEP = {"autoreset_mode": "SameStep"}


def heavy(robot):
    """A robot with twice the friction."""
    return replace(robot, friction=robot.friction.scale(coulomb=2.0, static=2.0))


def test_options_hold_for_one_episode_and_are_gone_after_the_automatic_reset(one_axis):
    env = gym.make_vec(ONE_AXIS, num_envs=2, frequencies=[1.0], **SAME_STEP)
    options = {"frequency": 2.0, "amplitude": 0.5, "horizon": 3, "plant": heavy(one_axis)}
    before = dict(options)
    env.reset(seed=0, options=options)
    assert options == before
    assert all(motion.task == {"frequency": 2.0, "amplitude": 0.5} for motion in env.core.motions)
    assert all(robot is options["plant"] for robot in env.core.plant.robots)
    for k in range(3):
        assert env.step(np.zeros((2, 1)))[3].all() == (k == 2)
    assert all(motion.task == {"frequency": 1.0, "amplitude": 1.0} for motion in env.core.motions)
    assert all(robot is env.core.plant.robot for robot in env.core.plant.robots)
    assert not any(env.step(np.zeros((2, 1)))[3].any() for _ in range(20))


def test_each_sub_environment_may_have_its_own_and_a_share_of_the_common_options():
    env = gym.make_vec(ONE_AXIS, num_envs=3, **SAME_STEP)
    each = [{}, {"frequency": 2.0}, {"horizon": 2, "amplitude": 0.1}]
    env.reset(seed=0, options={"frequency": 5.0, "each": each})
    assert [motion.task["frequency"] for motion in env.core.motions] == [5.0, 2.0, 5.0]
    assert [motion.task["amplitude"] for motion in env.core.motions] == [1.0, 1.0, 0.1]
    env.step(np.zeros((3, 1)))
    np.testing.assert_array_equal(env.step(np.zeros((3, 1)))[3], [False, False, True])


def test_each_goes_together_with_a_mask():
    env = gym.make_vec(ONE_AXIS, num_envs=3, frequencies=[1.0], **SAME_STEP)
    env.reset(seed=0)
    mask = np.array([True, False, True])
    env.reset(options={"reset_mask": mask, "each": [{"frequency": 2.0}, {"frequency": 3.0}, {"frequency": 4.0}]})
    assert [motion.task["frequency"] for motion in env.core.motions] == [2.0, 1.0, 4.0]


def test_a_fixed_option_is_not_drawn_and_the_rest_is():
    env = gym.make(JOINTS, robot="one_axis")
    env.reset(seed=3)
    free = env.unwrapped.core.motions[0].task
    env.reset(seed=3, options={"centre": [0.123]})
    fixed = env.unwrapped.core.motions[0].task
    assert fixed["centre"] == [0.123]
    assert fixed["peak_speed"] == free["peak_speed"]


@pytest.mark.parametrize("horizon", [1, 7])
def test_a_horizon_ends_the_episode_early_and_none_runs_to_the_end(horizon):
    env = gym.make(ONE_AXIS, horizon=horizon, duration=0.1)
    for options, steps in ((None, horizon), ({"horizon": horizon + 3}, horizon + 3), ({"horizon": None}, 25)):
        env.reset(seed=0, options=options)
        ends = [env.step([0.0])[2:4] for _ in range(steps)]
        assert ends == [(False, False)] * (steps - 1) + [(False, True)]
    env.reset(seed=0, options={"horizon": 1000})
    assert [env.step([0.0])[3] for _ in range(25)][-1]


def test_a_plant_may_be_a_name_a_description_or_a_file(one_axis, tmp_path):
    path = tmp_path / "mine.toml"
    builtin = load_robot("one_axis")
    path.write_text((resources.files("ffgym.robot") / "data" / "one_axis.toml").read_text())
    states = []
    for plant in (None, "one_axis", builtin, path, str(path)):
        for arguments, options in (({"plant": plant}, {}), ({}, {"plant": plant})):
            env = gym.make(ONE_AXIS, **arguments)
            env.reset(seed=0, options=options)
            for _ in range(5):
                env.step([0.3])
            states.append(plant_state(env))
    for state in states[1:]:
        np.testing.assert_array_equal(state, states[0])
    env = gym.make(ONE_AXIS, plant=heavy(one_axis))
    env.reset(seed=0)
    for _ in range(5):
        env.step([0.3])
    assert not np.array_equal(plant_state(env), states[0])


def test_the_controller_keeps_its_own_robot_whatever_the_plant(irb4600):
    loaded = PlantDistribution(payload=Uniform(20.0, 20.0)).draw(irb4600, np.random.default_rng(0))
    options = {"position": "p1", "speed": 0.1, "radii": 0.001}
    plain, other = gym.make(CIRCLE), gym.make(CIRCLE, plant=loaded)
    one, two = (env.reset(seed=0, options=options)[0] for env in (plain, other))
    for env in (plain, other):
        np.testing.assert_array_equal(env.unwrapped.action_torque, 2.5 * irb4600.friction.static)
    np.testing.assert_array_equal(one[6:], two[6:])  # the same reference, in the same scales
    banks = [env.unwrapped.core._bank for env in (plain, other)]
    rows = [bank.rows(bank.places(np.array([90]), 1))[0, 0] for bank in banks]
    np.testing.assert_array_equal(*rows)  # the rigid feed-forward knows nothing of the payload
    errors = [[np.abs(env.step(np.zeros(6))[0][:6]).max() for _ in range(100)][-1] for env in (plain, other)]
    assert errors[0] != errors[1]


def test_randomization_can_be_switched_on_and_off_for_an_episode(one_axis):
    half = PlantDistribution(friction_level=LogUniform(0.5, 0.5), payload=None)
    env = gym.make(ONE_AXIS, randomization=PlantDistribution())
    levels = []
    for options in ({}, {"randomization": None}, {"randomization": half}, {}):
        env.reset(seed=1, options=options)
        levels.append(float(env.unwrapped.core.plant.robots[0].friction.coulomb[0] / one_axis.friction.coulomb[0]))
    assert levels[1:3] == [1.0, 0.5]
    assert levels[0] == levels[3] not in (1.0, 0.5)


def test_randomization_draws_from_the_plant_of_the_episode(one_axis):
    env = gym.make(ONE_AXIS, randomization=PlantDistribution(friction_level=LogUniform(0.5, 0.5)))
    env.reset(seed=1, options={"plant": heavy(one_axis)})
    drawn = env.unwrapped.core.plant.robots[0].friction.coulomb
    np.testing.assert_allclose(drawn, one_axis.friction.coulomb, rtol=1e-12)


def test_the_single_environment_takes_the_same_options(one_axis):
    env = gym.make(ONE_AXIS)
    env.reset(seed=0, options={"frequency": 2.0, "horizon": 2, "plant": heavy(one_axis), "reward": "feedback_effort"})
    assert env.unwrapped.core.motions[0].task["frequency"] == 2.0
    assert [env.step([0.0])[3] for _ in range(2)] == [False, True]


@pytest.mark.parametrize("scale", [3.0, [3.0]])
def test_an_action_of_one_is_so_many_breakaway_torques(one_axis, scale):
    env = gym.make(ONE_AXIS, action_scale=scale)
    np.testing.assert_allclose(env.unwrapped.action_torque, 3.0 * one_axis.friction.static)
    env.unwrapped.action_torque[:] = 0.0  # a copy
    np.testing.assert_allclose(env.unwrapped.action_torque, 3.0 * one_axis.friction.static)


@pytest.mark.parametrize("preview", [0, 1, 5])
def test_as_many_samples_ahead_are_observed_as_asked_for(preview):
    env = gym.make(ONE_AXIS, preview=preview, duration=0.1)
    layout = env.unwrapped.observation_layout
    observation, _ = env.reset(seed=0)
    reference = env.unwrapped.core.motions[0].reference
    last = len(reference.t) - 1
    for k in range(26):
        for ahead in range(preview + 1):
            row = min(k + ahead, last)
            np.testing.assert_allclose(
                layout.read(observation, "reference_velocity", ahead), reference.motor_dq[row], rtol=1e-12
            )
        if k < 25:
            observation, *_ = env.step([0.0])
    assert f"reference_velocity_{preview + 1}" not in layout
