"""Adaptation: practice that costs nothing, then motions that count, all on one machine that is drawn."""

import gymnasium as gym
import numpy as np
import pytest

from ffgym.control import StaticLuGre
from ffgym.core.errors import FFGymError
from ffgym.envs import EpisodeRecorder, ResidualAction
from ffgym.envs.adapt import AdaptTasks
from tests.envs.env_samples import actions_for

SHORT = {"practice_speed": 0.1, "speeds": [0.1], "radii": [0.001], "budget": 1.5}


def follow(env, actions=None):
    """Task, practice, reward and machine of each step of an episode."""
    seen, ended = [], False
    while not ended:
        action = np.zeros(6) if actions is None else actions[len(seen) % len(actions)]
        _, reward, terminated, truncated, info = env.step(action)
        seen.append((info["task"], info["practice"], reward, env.unwrapped.core.plant.machines[0], info["time"]))
        ended = terminated or truncated
    return [list(column) for column in zip(*seen, strict=True)], info


def test_an_episode_is_practice_then_motions_that_count_on_one_machine():
    recorder = EpisodeRecorder()
    env = gym.make("ffgym/Adapt-v0", recorder=recorder, **SHORT)
    env.reset(seed=3)
    (tasks, practice, rewards, machines, time), info = follow(env)
    order = list(dict.fromkeys(tasks))
    assert order[0] == "p1, 100 mm/s, 3 mm"
    assert all(task.startswith(("p2", "p3", "p4")) for task in order[1:])
    first = practice.index(False)  # the step that ends practice is told with the next motion
    assert 0 < first * 0.004 <= 1.5
    assert not any(rewards[: first + 1])
    assert sum(rewards[first + 1 :]) < -1.0
    assert len(set(map(id, machines))) == 1
    assert info["score"]["length"] == len(tasks)
    # each motion begins at rest, with a recording of its own
    assert time.count(0.0) == len(recorder.recordings) - 1 == 2
    assert recorder.recordings[0].header.meta["task"]["position"] == "p1"
    # the next episode has another machine
    before = machines[0]
    env.reset()
    assert env.unwrapped.core.plant.machines[0] is not before


def test_a_motion_behind_practice_is_what_it_is_alone():
    machine = gym.make("ffgym/Adapt-v0").unwrapped.core.robot
    options = {"position": "p2", "speed": 0.1, "radii": [0.001]}
    recordings = []
    for name, arguments in (("ffgym/Adapt-v0", SHORT | {"plant": machine, "scored": 1}), ("ffgym/CirclePath-v1", {})):
        recorder = EpisodeRecorder()
        env = gym.make(name, recorder=recorder, layers=[ResidualAction(StaticLuGre(machine.friction))], **arguments)
        env.reset(seed=0, options=options)
        follow(env)
        recordings.append(recorder.recordings[-1])
    for column in recordings[0].columns:
        np.testing.assert_array_equal(recordings[0][column], recordings[1][column], err_msg=column)


def test_without_budget_there_is_no_practice_and_a_budget_is_never_exceeded():
    tasks = AdaptTasks()
    rng = np.random.default_rng(0)
    assert not any(motion.is_practice for motion in tasks.draw_series(rng, {"budget": 0.0}))
    durations = {}
    for budget in (2.0, 3.5, 10.0):
        first, *rest = tasks.draw_series(rng, {"budget": budget})
        assert first.is_practice
        assert not any(motion.is_practice for motion in rest)
        durations[budget] = first.reference.duration
        assert durations[budget] <= budget
        lap = tasks.count_laps(100.0) / 100.0
        assert tasks.count_laps(budget) >= int(lap * budget) - 1
    assert durations[10.0] > 8.0
    with pytest.raises(FFGymError, match=r"budget = 0.5 s must be 0 or at least"):
        gym.make("ffgym/Adapt-v0", budget=0.5)
    with pytest.raises(FFGymError, match="scored = 0"):
        gym.make("ffgym/Adapt-v0", scored=0)


def test_a_horizon_counts_over_all_motions_and_a_stop_in_practice_costs():
    env = gym.make("ffgym/Adapt-v0", horizon=300, **SHORT)
    env.reset(seed=0)
    (tasks, *_), _ = follow(env)
    assert len(tasks) == 300
    assert len(set(tasks)) > 1
    env = gym.make("ffgym/Adapt-v0", error_limit=1e-4, **SHORT)
    env.reset(seed=0)
    (_, practice, rewards, *_), _ = follow(env)
    assert practice[-1]
    assert rewards[-1] <= -100.0


def test_many_episodes_side_by_side_are_those_alone():
    actions = actions_for(450, 2, 6)
    envs = gym.make_vec("ffgym/Adapt-v0", num_envs=2, autoreset_mode="SameStep", **SHORT | {"scored": 1})
    envs.reset(seed=5)
    many = [envs.step(action) for action in actions]
    for i in range(2):
        env = gym.make("ffgym/Adapt-v0", **SHORT | {"scored": 1})
        env.reset(seed=5 + i)
        for k, action in enumerate(actions):
            observation, reward, terminated, truncated, _ = env.step(action[i])
            if terminated or truncated:
                observation, _ = env.reset()
            np.testing.assert_array_equal(many[k][0][i], observation)
            assert many[k][1][i] == reward
            assert many[k][3][i] == truncated
