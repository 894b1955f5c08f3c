"""Layers between agent and robot: each does what it says, in any order, single and vector, across episodes."""

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode

from ffgym.control import DynamicLuGreExact, StaticLuGre
from ffgym.envs import History, Hold, LowPassAction, ResidualAction
from ffgym.robot import load_robot
from tests.envs.env_samples import CIRCLE, ONE_AXIS, Remembering, actions_for, synchronous

FRICTION = load_robot("one_axis").friction


def stacks():
    """Layers in several orders, made anew for each environment."""
    return {
        "history": [History(3)],
        "low pass": [LowPassAction(20.0)],
        "hold": [Hold(4)],
        "law": [ResidualAction(StaticLuGre(FRICTION), scale=0.5)],
        "agent": [ResidualAction(Remembering())],
        "agent on histories, held": [History(3), ResidualAction(Remembering(), scale=0.7), Hold(3), History(2)],
        "everything": [
            ResidualAction(DynamicLuGreExact(FRICTION)),
            LowPassAction(30.0),
            ResidualAction(Remembering()),
            Hold(3),
        ],
        "held agent, filtered": [Hold(2), ResidualAction(Remembering()), LowPassAction(9.0), Hold(2), History(2)],
    }


@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
@pytest.mark.parametrize("name", stacks())
def test_a_stack_of_layers_is_the_same_single_and_vector(name, mode):
    n, settings = 3, {"horizon": 22, "error_limit": 0.04, "action_scale": 6.0, "frequencies": (0.5, 2.0)}
    native = gym.make_vec(ONE_AXIS, num_envs=n, autoreset_mode=mode, layers=stacks()[name], **settings)
    theirs = synchronous(ONE_AXIS, n, mode, lambda: settings | {"layers": stacks()[name]})
    np.testing.assert_array_equal(native.reset(seed=4)[0], theirs.reset(seed=4)[0])
    ended = np.zeros(n, dtype=int)
    for action in actions_for(50, n):
        ours, gymnasiums = native.step(action), theirs.step(action)
        for one, two in zip(ours[:4], gymnasiums[:4], strict=True):
            np.testing.assert_array_equal(one, two)
        done = ours[2] | ours[3]
        ended += done
        assert ("final_obs" in ours[4]) == ("final_obs" in gymnasiums[4])
        for i in np.flatnonzero(done) if mode is AutoresetMode.SAME_STEP else ():
            np.testing.assert_array_equal(ours[4]["final_obs"][i], gymnasiums[4]["final_obs"][i])
    assert ended.min() > 1


# History


def test_history_shows_the_newest_observation_first_and_fills_up_with_the_first():
    plain, env = gym.make(ONE_AXIS), gym.make(ONE_AXIS, layers=[History(3)])
    size = plain.observation_space.shape[0]
    assert env.observation_space.shape == (3 * size,)
    seen = [plain.reset(seed=1)[0]]
    np.testing.assert_array_equal(env.reset(seed=1)[0], np.tile(seen[0], 3))
    for k, action in enumerate(actions_for(5, 1)[:, 0], start=1):
        seen.append(plain.step(action)[0])
        wanted = np.concatenate([seen[max(k - back, 0)] for back in range(3)])
        observation = env.step(action)[0]
        np.testing.assert_array_equal(observation, wanted)
    layout = env.unwrapped.observation_layout
    np.testing.assert_array_equal(layout.read(observation, "error"), layout.read(seen[-1], "error"))


def test_the_last_observation_of_an_episode_carries_its_history_and_the_next_one_does_not():
    env = gym.make_vec(ONE_AXIS, num_envs=1, layers=[History(4)], horizon=5, autoreset_mode="SameStep")
    observation, _ = env.reset(seed=1)
    size = observation.shape[1] // 4
    for action in actions_for(5, 1):
        before = observation
        observation, *_, info = env.step(action)
    np.testing.assert_array_equal(info["final_obs"][0][size:], before[0, : 3 * size])
    assert not np.array_equal(info["final_obs"][0][:size], observation[0, :size])
    np.testing.assert_array_equal(observation, np.tile(observation[:, :size], (1, 4)))


def test_history_counts_decisions_of_the_stage_below():
    below = gym.make(ONE_AXIS, layers=[History(3), Hold(2)])
    above = gym.make(ONE_AXIS, layers=[Hold(2), History(3)])
    plain = gym.make(ONE_AXIS)
    for env in (below, above, plain):
        env.reset(seed=1)
    seen = []
    for action in actions_for(4, 1)[:, 0]:
        fine, coarse = below.step(action)[0], above.step(action)[0]
        seen += [plain.step(action)[0] for _ in range(2)]
    np.testing.assert_array_equal(fine, np.concatenate([seen[-1], seen[-2], seen[-3]]))
    np.testing.assert_array_equal(coarse, np.concatenate([seen[-1], seen[-3], seen[-5]]))


# LowPassAction


@pytest.mark.parametrize("cutoff", [2.0, 40.0])
def test_a_step_through_the_low_pass_rises_exponentially(cutoff):
    env = gym.make_vec(ONE_AXIS, num_envs=2, layers=[LowPassAction(cutoff)], horizon=30, autoreset_mode="SameStep")
    env.reset(seed=0)
    for _ in range(2):  # the filter begins anew with the episode
        for k in range(1, 30):
            observation, *_ = env.step(np.ones((2, 1)))
            torque = env.observation_layout.read(observation, "added_torque") / env.action_torque
            np.testing.assert_allclose(torque, 1 - np.exp(-2 * np.pi * cutoff * 0.004 * k), rtol=1e-12)
        env.step(np.ones((2, 1)))


def test_the_low_pass_knows_how_long_an_action_is_held():
    applied = []
    for layers in ([LowPassAction(10.0), Hold(5)], [Hold(5), LowPassAction(10.0)]):
        env = gym.make(ONE_AXIS, layers=layers)
        env.reset(seed=0)
        applied.append([float(env.step([1.0])[0][2]) for _ in range(6)])
    np.testing.assert_allclose(*applied, rtol=1e-12)
    np.testing.assert_allclose(applied[0], 1 - np.exp(-2 * np.pi * 10 * 0.02 * np.arange(1, 7)), rtol=1e-12)


def test_the_low_pass_limits_the_action_before_it_filters():
    env = gym.make(ONE_AXIS, layers=[LowPassAction(10.0)])
    env.reset(seed=0)
    beyond = env.step([100.0])[0][2]
    np.testing.assert_allclose(beyond, 1 - np.exp(-2 * np.pi * 10 * 0.004), rtol=1e-12)


# Hold


@pytest.mark.parametrize(("steps", "horizon"), [(1, 12), (5, 12), (5, 15), (40, 12)])
def test_holding_is_repeating_the_action_by_hand(steps, horizon):
    plain, env = (gym.make(ONE_AXIS, horizon=horizon, layers=layers) for layers in ([], [Hold(steps)]))
    assert env.unwrapped.decision_dt == pytest.approx(0.004 * steps)
    for episode in range(2):
        seed = 3 if episode == 0 else None
        plain.reset(seed=seed)
        env.reset(seed=seed)
        ended = False
        for action in actions_for(horizon, 1)[:, 0]:
            total = 0.0
            for _ in range(steps):
                observation, reward, terminated, truncated, info = plain.step(action)
                total += reward
                ended = terminated or truncated
                if ended:
                    break
            got = env.step(action)
            np.testing.assert_array_equal(got[0], observation)
            assert got[1:4] == (pytest.approx(total, rel=1e-12), terminated, truncated)
            np.testing.assert_array_equal(got[4]["u_c"], info["u_c"])
            if ended:
                break
        assert ended
        assert got[4]["score"]["length"] == -(-horizon // steps)  # decisions


def test_an_emergency_stop_ends_the_held_action():
    env = gym.make(ONE_AXIS, layers=[Hold(1000)], error_limit=0.02, action_scale=10.0)
    env.reset(seed=0)
    _, _, terminated, truncated, info = env.step([1.0])
    assert terminated
    assert not truncated
    assert info["time"] < 1.0


# Gymnasium's own wrappers


def test_gymnasiums_wrappers_work_outside_of_layers():
    env = gym.make(ONE_AXIS, layers=[History(2)], max_episode_steps=7)  # TimeLimit
    env = gym.wrappers.RecordEpisodeStatistics(gym.wrappers.FrameStackObservation(env, 3))
    size = env.unwrapped.observation_space.shape[0]
    assert env.reset(seed=0)[0].shape == (3, size)
    rewards = []
    for k in range(7):
        _, reward, _, truncated, info = env.step(env.action_space.sample())
        rewards.append(reward)
        assert truncated == (k == 6)
    assert info["episode"]["l"] == 7
    assert info["episode"]["r"] == pytest.approx(sum(rewards))


@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
def test_gymnasiums_vector_statistics_agree_with_the_score(mode):
    env = gym.make_vec(ONE_AXIS, num_envs=2, layers=[Hold(2)], horizon=9, autoreset_mode=mode)
    env = gym.wrappers.vector.RecordEpisodeStatistics(env)
    env.reset(seed=0)
    for _ in range(14):
        *_, info = env.step(env.action_space.sample())
        if "episode" in info:
            np.testing.assert_allclose(info["episode"]["r"], info["score"]["return"])
            np.testing.assert_array_equal(info["episode"]["l"], info["score"]["length"])
            break
    assert "episode" in info


def test_layers_work_on_the_six_axis_robot_too(irb4600):
    law = StaticLuGre(irb4600.friction)
    env = gym.make_vec(
        CIRCLE, num_envs=2, layers=[ResidualAction(law), LowPassAction(50.0), Hold(2), History(2)], horizon=20
    )
    observation, _ = env.reset(seed=0, options={"position": "p1", "speed": 0.1, "radii": 0.001})
    assert observation.shape == env.observation_space.shape
    for _ in range(10):
        observation, *_, truncated, _ = env.step(env.action_space.sample())
        assert observation in env.observation_space
    assert truncated.all()
