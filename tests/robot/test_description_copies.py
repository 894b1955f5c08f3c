"""Descriptions and arms can be copied and sent to other processes, and stay read-only."""

import copy
import pickle

import gymnasium as gym
import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.robot import ModelOptions, RigidArm, builtin_robots, compile_model, load_robot, physics_fingerprint


@pytest.mark.parametrize("make", [copy.deepcopy, lambda robot: pickle.loads(pickle.dumps(robot))])
@pytest.mark.parametrize("name", builtin_robots())
def test_a_copy_of_a_description_is_the_same_robot(name, make):
    robot = load_robot(name)
    other = make(robot)
    prints = [physics_fingerprint(compile_model(r, ModelOptions())) for r in (robot, other)]
    assert prints[0] == prints[1]
    assert other.quantities.keys() == robot.quantities.keys()
    with pytest.raises(TypeError):
        other.quantities["x"] = None
    if robot.work_area is not None:
        np.testing.assert_array_equal(other.position("p1"), robot.position("p1"))
        with pytest.raises(TypeError):
            other.work_area.positions["p1"] = None


@pytest.mark.parametrize("make", [copy.deepcopy, lambda arm: pickle.loads(pickle.dumps(arm))])
def test_a_copy_of_an_arm_moves_as_the_arm_does(make):
    arm = RigidArm(load_robot("two_link"))
    other = make(arm)
    q = np.array([[0.3, -0.7]])
    np.testing.assert_array_equal(other.mass_matrix(q), arm.mass_matrix(q))
    np.testing.assert_array_equal(other.holding_torque(q), arm.holding_torque(q))


def test_an_environment_with_a_description_as_argument_can_be_made_again(one_axis):
    env = gym.make("ffgym/OneAxis-v0", robot=one_axis)
    again = env.spec.make()
    np.testing.assert_array_equal(env.reset(seed=0)[0], again.reset(seed=0)[0])


@pytest.mark.parametrize(
    "make", [lambda: gym.make("ffgym/OneAxis-v0").unwrapped, lambda: gym.make_vec("ffgym/OneAxis-v0")]
)
def test_an_environment_says_that_it_cannot_be_copied(make):
    for act in (copy.deepcopy, pickle.dumps):
        with pytest.raises(FFGymError, match="cannot be copied or pickled"):
            act(make())
