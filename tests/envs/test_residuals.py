"""Residuals: an agent's action on top of a law of the reference, or on top of another agent with a memory."""

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode

from ffgym.control import DynamicLuGreExact, NoCompensation, StaticLuGre
from ffgym.envs import History, ResidualAction
from ffgym.robot import load_robot
from tests.envs.env_samples import JOINTS, ONE_AXIS, Remembering, actions_for

FRICTION = load_robot("one_axis").friction

# Residual on a law


@pytest.mark.parametrize("law", [NoCompensation(), StaticLuGre(FRICTION), DynamicLuGreExact(FRICTION)])
def test_a_residual_on_a_law_adds_to_its_torque(law):
    env = gym.make(ONE_AXIS, layers=[ResidualAction(law, scale=0.25)], action_scale=20.0, horizon=80)
    for seed in (0, None):
        observation, _ = env.reset(seed=seed)
        core = env.unwrapped.core
        torque = law.torque(core.motions[0].reference)
        for k, action in enumerate(actions_for(80, 1)[:, 0] * 2, start=1):
            observation, *_ = env.step(action)
            added = env.unwrapped.observation_layout.read(observation, "added_torque")
            wanted = torque[k] + 0.25 * np.clip(action, -1, 1) * env.unwrapped.action_torque
            np.testing.assert_allclose(added, wanted, rtol=1e-12, atol=1e-12)


def test_the_sum_of_law_and_residual_is_clipped_to_the_range_of_actions():
    env = gym.make(ONE_AXIS, layers=[ResidualAction(StaticLuGre(FRICTION))], action_scale=0.5)
    env.reset(seed=0)
    added = [env.step([1.0])[0][2] for _ in range(200)]
    assert max(added) == 1.0
    assert min(added) >= -1.0
    env.reset(seed=0)
    assert min(env.step([-1.0])[0][2] for _ in range(200)) == -1.0


def test_a_law_on_many_motions_keeps_to_the_motion_of_each_episode():
    law = StaticLuGre(FRICTION)
    env = gym.make_vec(
        JOINTS, num_envs=2, robot="one_axis", layers=[ResidualAction(law)], horizon=2, autoreset_mode="SameStep",
        duration=1.0, action_scale=20.0,
    )  # fmt: skip
    env.reset(seed=0)
    stage = env._stage
    for _ in range(150):
        wanted = np.stack([law.torque(motion.reference)[2] for motion in env.core.motions])
        env.step(np.zeros((2, 1)))
        *_, info = env.step(np.zeros((2, 1)))
        added = env.observation_layout.read(np.stack(list(info["final_obs"])), "added_torque")
        np.testing.assert_allclose(added, wanted, atol=1e-12)
        assert len(stage._known) <= 130  # and it does not remember all motions there ever were


# Residual on an agent


def starts_of(mode, horizon, steps, n=2):
    agent = Remembering()
    env = gym.make_vec(ONE_AXIS, num_envs=n, layers=[ResidualAction(agent)], horizon=horizon, autoreset_mode=mode)
    env.reset(seed=0)
    for action in actions_for(steps, n):
        env.step(action)
    return np.array([call["start"] for call in agent.calls])


def test_the_base_agent_is_told_of_every_beginning_in_both_autoreset_modes():
    same = starts_of(AutoresetMode.SAME_STEP, horizon=4, steps=12)
    np.testing.assert_array_equal(same, np.tile([[True] * 2, [False] * 2, [False] * 2, [False] * 2], (3, 1)))
    following = starts_of(AutoresetMode.NEXT_STEP, horizon=4, steps=15)  # all end together: one step of resets only
    np.testing.assert_array_equal(following, same)


def test_the_base_agent_sees_the_stage_below_and_its_own_memory():
    agent = Remembering()
    env = gym.make_vec(
        ONE_AXIS, num_envs=2, layers=[History(2), ResidualAction(agent, deterministic=False)], autoreset_mode="Disabled"
    )
    observation, _ = env.reset(seed=0)
    for k, action in enumerate(actions_for(6, 2)):
        before = observation
        observation, *_ = env.step(action)
        np.testing.assert_array_equal(agent.calls[k]["observation"], before)
        assert agent.calls[k]["deterministic"] is False
        if k:
            np.testing.assert_array_equal(agent.calls[k]["state"], agent.calls[k - 1]["steps"])
    env.reset(options={"reset_mask": np.array([False, True])})
    env.step(np.zeros((2, 1)))
    np.testing.assert_array_equal(agent.calls[-1]["start"], [False, True])
    env.step(np.zeros((2, 1)))
    np.testing.assert_array_equal(agent.calls[-1]["start"], [False, False])


def test_the_base_agents_action_is_added_in_full_and_the_residual_in_part():
    agent = Remembering(size=0.1)
    env = gym.make(ONE_AXIS, layers=[ResidualAction(agent, scale=0.5)])
    env.reset(seed=0)
    observation, *_ = env.step([-0.2])
    np.testing.assert_allclose(observation[2], 0.1 * agent.calls[0]["steps"][0, 0] - 0.1, rtol=1e-12)
    observation, *_ = env.step([-7.0])  # as if it were -1
    np.testing.assert_allclose(observation[2], 0.1 * agent.calls[1]["steps"][0, 0] - 0.5, rtol=1e-12)


def test_a_base_agent_cannot_change_the_observations_it_gets():
    class Vandal(Remembering):
        def predict(self, observation, *args, **kwargs):
            result = super().predict(observation, *args, **kwargs)
            observation[:] = np.nan
            kwargs["episode_start"] = None
            return result

    env = gym.make(ONE_AXIS, layers=[History(2), ResidualAction(Vandal())])
    observation, _ = env.reset(seed=0)
    for _ in range(3):
        before = observation
        observation, *_ = env.step([0.0])
        assert np.isfinite(before).all()
    assert np.isfinite(observation).all()
