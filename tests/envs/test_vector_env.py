"""The native vector environment behaves as Gymnasium's own over single environments, bit for bit."""

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode

from ffgym.core.errors import FFGymError
from tests.envs.env_samples import CIRCLE, JOINTS, ONE_AXIS, actions_for, assert_same_info, plant_state, synchronous

N, STEPS = 3, 60
UNEVEN = {"error_limit": 0.02, "horizon": 20, "frequencies": (0.5, 2.0), "action_scale": 6.0}
"""Emergency stops here and there: episodes end at different times."""


def roll_both(mode, steps=STEPS, each_step=None):
    native = gym.make_vec(ONE_AXIS, num_envs=N, autoreset_mode=mode, **UNEVEN)
    theirs = synchronous(ONE_AXIS, N, mode, lambda: dict(UNEVEN))
    results = [env.reset(seed=2) for env in (native, theirs)]
    np.testing.assert_array_equal(results[0][0], results[1][0])
    assert_same_info(results[0][1], results[1][1])
    ends = []
    for action in actions_for(steps, N):
        ours, gymnasiums = (env.step(action) for env in (native, theirs))
        for one, two in zip(ours[:4], gymnasiums[:4], strict=True):
            np.testing.assert_array_equal(one, two)
            assert one.dtype == two.dtype
        assert_same_info(ours[4], gymnasiums[4])
        extra = {key.lstrip("_") for key in ours[4]} - {key.lstrip("_") for key in gymnasiums[4]}
        assert extra <= {"score"}
        ends.append(np.stack(ours[2:4]))
        if each_step is not None:
            each_step(native, theirs, ours)
    return np.array(ends)


@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
def test_autoreset_is_gymnasiums_with_its_infos_and_masks(mode):
    ends = roll_both(mode)
    terminated, truncated = ends.sum(axis=0)
    assert terminated.min() > 0
    assert truncated.sum() > 0
    uneven = ends.any(axis=1).any(axis=1) & ~ends.any(axis=1).all(axis=1)
    assert uneven.any()


def test_without_autoreset_those_that_ended_are_reset_by_mask():
    resets = 0

    def reset_ended(native, theirs, ours):
        nonlocal resets
        done = ours[2] | ours[3]
        if done.any():
            resets += 1
            seeds = [None if k else 40 + resets for k in range(N)]
            ours, gymnasiums = (env.reset(seed=seeds, options={"reset_mask": done.copy()}) for env in (native, theirs))
            for i in range(N):  # Gymnasium gives its last observation elsewhere, as we do
                np.testing.assert_array_equal(ours[0][i], gymnasiums[0][i])
            for key in gymnasiums[1]:
                if not key.startswith("_"):
                    for i in np.flatnonzero(done):
                        np.testing.assert_array_equal(ours[1][key][i], gymnasiums[1][key][i])

    roll_both(AutoresetMode.DISABLED, each_step=reset_ended)
    assert resets > 3


def test_without_autoreset_those_that_ended_wait_for_the_others():
    env = gym.make_vec(ONE_AXIS, num_envs=2, autoreset_mode="Disabled")
    env.reset(seed=0, options={"each": [{"horizon": 1}, {"horizon": 3}]})
    *_, info = env.step(np.zeros((2, 1)))
    assert info["score"]["_return"].tolist() == [True, False]
    before = plant_state(env)
    for k in (2, 3):
        _, reward, terminated, truncated, info = env.step(
            np.array([[np.nan], [0.3]])
        )  # the action of one that waits is nothing
        np.testing.assert_array_equal(plant_state(env)[0], before[0])
        assert reward[0] == 0.0 > reward[1]
        assert (terminated.tolist(), truncated.tolist()) == ([False, False], [True, k == 3])
        assert info["time"].tolist() == pytest.approx([0.004, k * 0.004])
        assert ("score" in info) == (k == 3)
    with pytest.raises(FFGymError, match="have ended; call reset"):
        env.step(np.zeros((2, 1)))
    env.reset(options={"reset_mask": np.array([True, False])})
    assert env.step(np.zeros((2, 1)))[3].tolist() == [False, True]


def test_a_partial_reset_leaves_the_others_alone():
    env = gym.make_vec(ONE_AXIS, num_envs=3, autoreset_mode="Disabled", horizon=30)
    observation, _ = env.reset(seed=0)
    for action in actions_for(7, 3):
        observation, *_ = env.step(action)
    state, seeds, mask = plant_state(env), env.np_random_seed, np.array([False, True, False])
    after, info = env.reset(seed=[7, 8, 9], options={"reset_mask": mask})
    np.testing.assert_array_equal(after[~mask], observation[~mask])
    np.testing.assert_array_equal(plant_state(env)[~mask], state[~mask])
    assert not np.array_equal(plant_state(env)[mask], state[mask])
    np.testing.assert_array_equal(info["time"] > 0, ~mask)
    assert env.np_random_seed == (seeds[0], 8, seeds[2])


@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
def test_a_reset_by_hand_in_the_middle_of_an_episode_counts_anew(mode):
    env = gym.make_vec(ONE_AXIS, num_envs=2, horizon=6, autoreset_mode=mode)
    env.reset(seed=0)
    for _ in range(4):
        env.step(np.zeros((2, 1)))
    env.reset(options={"reset_mask": np.array([True, False])})
    truncated = np.array([env.step(np.zeros((2, 1)))[3] for _ in range(6)])
    np.testing.assert_array_equal(truncated[:, 0], [False] * 5 + [True])
    assert truncated[1, 1]


def test_a_mask_after_the_end_begins_the_episode_at_once_in_next_step_mode():
    env = gym.make_vec(ONE_AXIS, num_envs=2, horizon=3)
    env.reset(seed=0)
    for _ in range(3):
        *_, truncated, _ = env.step(np.zeros((2, 1)))
    assert truncated.all()
    env.reset(options={"reset_mask": np.array([True, False])})
    _, reward, _, _, info = env.step(np.full((2, 1), 0.5))
    np.testing.assert_array_equal(info["time"] > 0, [True, False])
    assert reward[0] < 0
    assert reward[1] == 0


def test_seeds_are_counted_up_or_given_one_by_one():
    one, two, three = (gym.make_vec(JOINTS, num_envs=3, robot="one_axis", duration=1.0) for _ in range(3))
    first = one.reset(seed=5)[0]
    np.testing.assert_array_equal(first, two.reset(seed=[5, 6, 7])[0])
    np.testing.assert_array_equal(first, three.reset(seed=np.array([5, 6, 7]))[0])
    assert one.np_random_seed == two.np_random_seed == three.np_random_seed == (5, 6, 7)
    rest = one.reset()[0]
    mixed = two.reset(seed=[None, 6, None])[0]
    np.testing.assert_array_equal(mixed[[0, 2]], rest[[0, 2]])
    np.testing.assert_array_equal(mixed[1], first[1])


def test_randomness_is_one_generator_per_sub_environment():
    env = gym.make_vec(ONE_AXIS, num_envs=2)
    assert env.np_random_seed == (None, None)
    assert env.np_random == ()
    env.reset()
    assert len(env.np_random) == 2
    assert None not in env.np_random_seed
    state = env.np_random[0].bit_generator.state
    assert state != env.np_random[1].bit_generator.state


def test_a_first_reset_without_seed_differs_from_run_to_run():
    observations = [gym.make(JOINTS, robot="one_axis").reset()[0] for _ in range(2)]
    assert not np.array_equal(*observations)


def test_the_spec_makes_the_same_environment_again():
    env = gym.make_vec(CIRCLE, num_envs=2, speeds=[0.1], positions=["p2"], order="one", radii=[0.001])
    assert env.spec.id == CIRCLE
    again = gym.make_vec(env.spec)
    np.testing.assert_array_equal(env.reset(seed=1)[0], again.reset(seed=1)[0])


def test_closing_twice_is_closing_once():
    for env in (gym.make(ONE_AXIS), gym.make_vec(ONE_AXIS, num_envs=2)):
        env.reset(seed=0)
        env.close()
        env.close()


def test_scores_are_sums_and_counts_of_the_episode():
    env = gym.make_vec(ONE_AXIS, num_envs=2, autoreset_mode="SameStep")
    env.reset(seed=0, options={"each": [{"horizon": 4}, {"horizon": 7}]})
    rewards = []
    for k in range(7):
        _, reward, _, truncated, info = env.step(np.full((2, 1), 0.3))
        rewards.append(reward)
        assert ("score" in info) == truncated.any()
        for i in np.flatnonzero(truncated):
            assert info["score"]["length"][i] == k + 1 == (4, 7)[i]
            np.testing.assert_allclose(info["score"]["return"][i], np.sum(rewards, axis=0)[i], rtol=1e-12)
            np.testing.assert_array_equal(info["_score"], truncated)


@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
def test_scores_begin_anew_with_each_episode(mode):
    env = gym.make_vec(ONE_AXIS, num_envs=2, horizon=4, autoreset_mode=mode)
    env.reset(seed=0, options={"each": [{}, {"horizon": 2}]})
    scores = [env.step(np.zeros((2, 1)))[-1].get("score") for _ in range(15)]
    lengths = [score["length"] for score in scores if score]
    assert np.max(lengths) == 4
    assert np.sum(lengths) >= 22
    assert all(score["length"][i] in (0, 2, 4) for score in scores if score for i in range(2))


def test_observations_beyond_their_bounds_are_clipped():
    env = gym.make(ONE_AXIS, error_limit=1e6)
    env.reset(seed=0, options={"frequency": 0.05, "amplitude": 900.0})
    observations = np.array([env.step([0.0])[0] for _ in range(400)])
    assert observations.max() == env.observation_space.high[0]
    assert (np.abs(observations) <= env.observation_space.high).all()


def test_writing_into_what_was_returned_changes_nothing():
    env, untouched = (gym.make_vec(CIRCLE, num_envs=2, speeds=[0.1], radii=[0.001]) for _ in range(2))
    for each in (env, untouched):
        each.reset(seed=0)
    for action in actions_for(3, 2, 6):
        *results, info = env.step(action)
        for array in (*results, *(value for key, value in info.items() if not key.startswith("_"))):
            array[...] = 1
        for key, value in untouched.step(action)[-1].items():
            if not key.startswith("_"):
                np.testing.assert_array_equal(env.core.info()[key], value, err_msg=key)
    np.testing.assert_array_equal(plant_state(env), plant_state(untouched))


def test_what_was_returned_stays_as_it_was():
    env = gym.make_vec(CIRCLE, num_envs=2, speeds=[0.1], radii=[0.001])
    env.reset(seed=0)
    actions = actions_for(3, 2, 6)
    *results, info = env.step(actions[0])
    seen = {"observation": results[0], "reward": results[1], "terminated": results[2], "truncated": results[3]} | info
    before = {name: value.copy() for name, value in seen.items()}
    for action in actions[1:]:
        env.step(action)
    for name, value in seen.items():
        np.testing.assert_array_equal(value, before[name], err_msg=name)
