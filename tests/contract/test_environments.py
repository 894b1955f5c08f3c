"""The same questions to every registered environment; a new id is picked up by itself."""

import hashlib
import os
import shutil
import subprocess
import sys

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode

import ffgym
from ffgym.core.registration import ENVIRONMENTS

IDS = sorted(name for name in gym.registry if name.startswith("ffgym/"))
LATER = ("-v1", "Adapt-v0")
"""Endings of ids on machines with drives that are not ideal."""
PATIENT = [
    pytest.param(name, marks=pytest.mark.slow) if "Workcell" in name or name.endswith(LATER) else name for name in IDS
]
"""For questions that take many steps: drives that are not ideal take ten times longer than the engine's own physics, a
workcell twenty times."""
SHORT = 40
"""Steps: enough to leave standstill where there is one, short enough to end many episodes."""


def test_every_id_of_the_table_is_registered_and_no_other():
    assert sorted(ENVIRONMENTS) == IDS
    assert len(IDS) >= 3


@pytest.mark.parametrize("name", IDS)
def test_gymnasium_finds_nothing_to_complain_about(name):
    check_env(gym.make(name).unwrapped, skip_render_check=True)  # warnings are errors; rendering has tests of its own


@pytest.mark.skipif(
    shutil.which("xvfb-run") is None and os.environ.get("FFGYM_REQUIRE_GL") != "1",
    reason="needs xvfb-run, a screen in memory, to open windows",
)
@pytest.mark.parametrize("name", PATIENT)
def test_gymnasium_finds_nothing_to_complain_about_in_any_render_mode(name):
    program = (
        "import gymnasium as gym, ffgym; from gymnasium.utils.env_checker import check_env;"
        f"check_env(gym.make(gym.spec('{name}')).unwrapped); print('no complaint')"
    )
    command = ["xvfb-run", "-a", sys.executable, "-W", "error", "-c", program]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.stdout.strip(), done.stderr) == ("no complaint", "")


@pytest.mark.parametrize("name", PATIENT)
def test_stable_baselines_finds_nothing_to_complain_about(name):
    checker = pytest.importorskip("stable_baselines3.common.env_checker")
    checker.check_env(gym.make(name), warn=True, skip_render_check=True)


@pytest.mark.parametrize("name", IDS)
def test_the_id_works_with_its_module_in_front(name):
    assert gym.make(f"ffgym:{name}").spec.id == name
    assert gym.make_vec(f"ffgym:{name}", num_envs=2).num_envs == 2


def actions_for(env, steps, n, seed=5):
    return np.random.default_rng(seed).uniform(-1, 1, size=(steps, n, env.single_action_space.shape[0]))


def roll(name, n, actions, seed, mode=AutoresetMode.SAME_STEP, **kwargs):
    """Everything a vector environment returns over `actions` (T, n, N)."""
    env = gym.make_vec(name, num_envs=n, autoreset_mode=mode, **kwargs)
    seen = [env.reset(seed=seed)[0]]
    infos = []
    for action in actions:
        *result, info = env.step(action)
        seen += result
        infos.append(info)
    env.close()
    return seen, infos


def digest(arrays):
    return hashlib.sha256(b"".join(np.ascontiguousarray(a).tobytes() for a in arrays)).hexdigest()


@pytest.mark.parametrize("name", PATIENT)
def test_bits_do_not_depend_on_threads_or_on_the_process(name):
    env = gym.make_vec(name, num_envs=3)
    actions = actions_for(env, SHORT, 3)
    digests = {digest(roll(name, 3, actions, seed=11, n_threads=threads, horizon=17)[0]) for threads in (1, 2)}
    program = (
        "import numpy as np, sys; sys.path.insert(0, '.');"
        "from tests.contract.test_environments import *;"
        f"actions = actions_for(gym.make_vec('{name}', num_envs=3), SHORT, 3);"
        f"print(digest(roll('{name}', 3, actions, seed=11, horizon=17)[0]))"
    )
    out = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    digests.add(out.stdout.strip())
    assert len(digests) == 1


@pytest.mark.parametrize("name", PATIENT)
def test_a_sub_environment_equals_the_single_environment_bit_for_bit(name):
    n, horizon = 3, 17
    vector = gym.make_vec(name, num_envs=n)
    actions = actions_for(vector, SHORT, n)
    results = {mode: roll(name, n, actions, seed=3, mode=mode, horizon=horizon) for mode in list(AutoresetMode)[:2]}
    for i in range(n):
        single = gym.make(name, horizon=horizon)
        observation, _ = single.reset(seed=3 + i)
        episode = [observation]
        same, same_infos = results[AutoresetMode.SAME_STEP]
        ended = False
        for k in range(SHORT):
            # same-step: every step is one of the single environment, which is reset by hand
            observation, reward, terminated, truncated, info = single.step(actions[k, i])
            got = [column[i] for column in same[1 + 4 * k : 5 + 4 * k]]
            ended = terminated or truncated
            if ended:
                np.testing.assert_array_equal(same_infos[k]["final_obs"][i], observation)
                np.testing.assert_array_equal(same_infos[k]["final_info"]["u_p"][i], info["u_p"])
                assert same_infos[k]["score"]["return"][i] == info["score"]["return"]
                observation, info = single.reset()
            np.testing.assert_array_equal(got[0], observation)
            assert got[1:] == [reward, terminated, truncated]
            assert same_infos[k]["_u_c"][i]
            np.testing.assert_array_equal(same_infos[k]["u_c"][i], info["u_c"])
            episode.append(observation)
        assert 2 * horizon < SHORT  # episodes ended on the way


@pytest.mark.parametrize("name", PATIENT)
def test_next_step_autoreset_spends_one_step_on_the_reset(name):
    n, horizon = 2, 7
    env = gym.make_vec(name, num_envs=n, horizon=horizon)
    actions = actions_for(env, 3 * (horizon + 1), n)
    seen, _ = roll(name, n, actions, seed=3, mode=AutoresetMode.NEXT_STEP, horizon=horizon)
    for i in range(n):
        single = gym.make(name, horizon=horizon)
        observation, _ = single.reset(seed=3 + i)
        ended = False
        for k in range(len(actions)):
            if ended:
                (observation, _), reward, terminated, truncated = single.reset(), 0.0, False, False
            else:
                observation, reward, terminated, truncated, _ = single.step(actions[k, i])
            ended = terminated or truncated
            np.testing.assert_array_equal(seen[1 + 4 * k][i], observation)
            assert [c[i] for c in seen[2 + 4 * k : 5 + 4 * k]] == [reward, terminated, truncated]


@pytest.mark.parametrize("name", IDS)
def test_a_run_after_a_perturbed_episode_equals_a_fresh_one(name):
    wild, fresh = gym.make(name), gym.make(name)
    actions = actions_for(gym.make_vec(name), SHORT, 1)[:, 0]
    wild.reset(seed=1)
    for action in np.sign(actions):
        wild.step(action)
    np.testing.assert_array_equal(wild.reset(seed=9)[0], fresh.reset(seed=9)[0])
    for action in actions:
        one, two = wild.step(action), fresh.step(action)
        np.testing.assert_array_equal(one[0], two[0])
        assert one[1:4] == two[1:4]
    a, b = (env.unwrapped.core.plant.batch.state for env in (wild, fresh))
    np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize("name", IDS)
def test_reset_without_seed_goes_on_with_the_randomness_of_the_last_seed(name):
    env = gym.make(name)
    episodes = []
    for _ in range(2):
        env.reset(seed=3)
        episodes.append([env.reset()[0] for _ in range(5)])
    np.testing.assert_array_equal(*episodes)
    assert env.np_random_seed == 3


@pytest.mark.parametrize("name", IDS)
def test_observations_stay_in_their_space_and_are_read_by_name(name):
    env = gym.make(name, preview=3)
    layout = env.unwrapped.observation_layout
    assert layout.size == env.observation_space.shape[0] == sum(e.slice.stop - e.slice.start for e in layout.values())
    observation, _ = env.reset(seed=0)
    action = np.full(env.action_space.shape, 0.25)
    before = observation
    for _ in range(3):
        before = observation
        observation, *_ = env.step(action)
        assert observation in env.observation_space
    for quantity in ("position", "velocity", "acceleration"):
        was_ahead = layout.read(before, f"reference_{quantity}", ahead_by=1)
        np.testing.assert_allclose(was_ahead, layout.read(observation, f"reference_{quantity}"), atol=1e-12)
    torque = layout.read(observation, "added_torque")
    np.testing.assert_allclose(torque, 0.25 * env.unwrapped.action_torque)


@pytest.mark.parametrize("name", IDS)
def test_what_is_returned_is_not_changed_by_later_steps(name):
    env = gym.make_vec(name, num_envs=2)
    env.reset(seed=0)
    *results, info = env.step(env.action_space.sample())
    kept = [np.copy(r) for r in results], {k: np.copy(v) for k, v in info.items()}
    env.step(env.action_space.sample())
    for was, now in zip(kept[0], results, strict=True):
        np.testing.assert_array_equal(was, now)
    for key, was in kept[1].items():
        np.testing.assert_array_equal(was, info[key])


@pytest.mark.parametrize("name", IDS)
def test_version_and_kwargs_survive_in_the_spec(name):
    env = gym.make(name, horizon=3)
    again = env.spec.make()
    again.reset(seed=0)
    ends = [again.step(again.action_space.sample())[3] for _ in range(3)]
    assert ends == [False, False, True]
    assert ffgym.__version__
