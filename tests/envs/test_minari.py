"""Episodes go into a Minari data set and come out as they were; the environment is recovered with it."""

import builtins

import gymnasium as gym
import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.core.provenance import versions
from ffgym.envs import History, Sensing
from ffgym.envs.minari import collect, write_dataset

CIRCLES = "ffgym/CirclePath-v0"


@pytest.fixture(autouse=True)
def _datasets(tmp_path, monkeypatch):
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))


class Wild:
    """Actions beyond their bounds, from what it sees, and a count of its steps as state."""

    def __init__(self):
        self.starts = []

    def predict(self, observation, state=None, episode_start=None, deterministic=False):
        assert deterministic
        self.starts.append((state, bool(episode_start[0])))
        return 3 * np.sin(observation[:, :6] + np.arange(6)), (state or 0) + 1


def replay(env, episode, metadata):
    """Observations and rewards of the actions of an episode in another environment."""
    observation, _ = env.reset(seed=metadata["seed"], options=metadata.get("options"))
    observations, rewards = [observation], []
    for action in episode.actions:
        observation, reward, *_ = env.step(action)
        observations.append(observation)
        rewards.append(reward)
    return np.array(observations), np.array(rewards)


@pytest.mark.parametrize("name", [CIRCLES, "ffgym/OneAxis-v0", "ffgym/JointMotion-v0"])
def test_a_recovered_environment_repeats_the_episodes_bit_for_bit(name):
    minari = pytest.importorskip("minari")
    agent = Wild() if name != "ffgym/OneAxis-v0" else None
    env = gym.make(name, horizon=12)
    written = write_dataset("ffgym/test-v0", env, collect(env, agent, n_episodes=2, seed=7))
    dataset = minari.load_dataset("ffgym/test-v0")
    assert dataset.total_episodes == written.total_episodes == 2
    assert dataset.total_steps == 24
    again = dataset.recover_environment()
    assert again.spec.id == name
    metadata = list(dataset.storage.get_episode_metadata(range(2)))
    assert [m["seed"] for m in metadata] == [7, 8]
    for own, episode in zip(metadata, dataset.iterate_episodes(), strict=True):
        observations, rewards = replay(again, episode, own)
        np.testing.assert_array_equal(episode.observations, observations)
        np.testing.assert_array_equal(episode.rewards, rewards)
        assert episode.truncations.tolist() == 11 * [False] + [True]
        assert not episode.terminations.any()
        assert episode.actions.dtype == again.action_space.dtype
        assert all(action in again.action_space for action in episode.actions)
    if agent is not None:
        assert np.abs(episode.actions).max() == 1.0


def test_metadata_have_task_options_versions_and_physics():
    minari = pytest.importorskip("minari")
    env = gym.make(CIRCLES, horizon=3)
    options = {"position": "p2", "speed": 0.04, "radii": [0.001], "reward": "path_error"}
    episodes = collect(env, options=options, info_keys=("path_error", "u_p"))
    write_dataset("test-v0", env, episodes, author="A. Nonymous", algorithm_name="zero")
    dataset = minari.load_dataset("test-v0")
    (metadata,) = dataset.storage.get_episode_metadata([0])
    assert metadata["task"]["position"] == metadata["options"]["position"] == "p2"
    assert metadata["options"]["reward"] == "path_error"
    np.testing.assert_array_equal(metadata["task"]["radii"], [0.001])
    assert metadata["physics_fingerprint"] == env.unwrapped.core.plant.fingerprint()
    assert dataset.storage.metadata["versions"] == versions()
    assert dataset.storage.metadata["author"] == {"A. Nonymous"}
    assert f"mujoco=={versions()['mujoco']}" in dataset.storage.metadata["requirements"]
    infos = dataset[0].infos
    assert infos["u_p"].shape == (4, 6)
    np.testing.assert_allclose(dataset[0].rewards, -infos["path_error"][1:] / 1e-4)


def test_an_agent_gets_its_state_back_and_is_told_of_starts():
    agent = Wild()
    collect(gym.make(CIRCLES, horizon=3), agent, n_episodes=2)
    assert agent.starts == 2 * [(None, True), (1, False), (2, False)]


def test_an_environment_with_objects_as_arguments_is_written_without_its_spec():
    minari = pytest.importorskip("minari")
    env = gym.make(CIRCLES, horizon=3, layers=(History(2),))
    episodes = collect(env)
    with pytest.raises(FFGymError, match="recoverable=False"):
        write_dataset("test-v0", env, episodes)
    write_dataset("test-v0", env, episodes, recoverable=False)
    dataset = minari.load_dataset("test-v0")
    assert dataset.env_spec is None
    assert dataset[0].observations.shape == (4, *env.observation_space.shape)


@pytest.mark.parametrize("name", ["no version", "test", "test-v", "../test-v0", ""])
def test_an_id_without_name_and_version_is_refused(name):
    pytest.importorskip("minari")
    env = gym.make(CIRCLES, horizon=1)
    with pytest.raises(FFGymError, match="dataset_id"):
        write_dataset(name, env, collect(env))


def test_an_id_that_is_taken_is_refused():
    pytest.importorskip("minari")
    env = gym.make(CIRCLES, horizon=1)
    episodes = collect(env)
    write_dataset("test-v0", env, episodes)
    with pytest.raises(FFGymError, match="already exists"):
        write_dataset("test-v0", env, episodes)


def test_options_that_have_no_written_form_are_refused_before_anything_is_written(tmp_path):
    pytest.importorskip("minari")
    env = gym.make(CIRCLES, horizon=1)
    episodes = collect(env, options={"sensing": Sensing(encoder_bits=16)})
    with pytest.raises(FFGymError, match="'sensing'"):
        write_dataset("test-v0", env, episodes)
    assert list(tmp_path.iterdir()) == []


def test_nothing_to_write_is_refused():
    pytest.importorskip("minari")
    with pytest.raises(FFGymError, match="no episodes"):
        write_dataset("test-v0", gym.make(CIRCLES), [])


def test_without_minari_the_way_out_is_said(monkeypatch):
    real = builtins.__import__

    def refuse(name, *arguments, **keywords):
        if name.partition(".")[0] == "minari":
            raise ImportError(name)
        return real(name, *arguments, **keywords)

    monkeypatch.setattr(builtins, "__import__", refuse)
    with pytest.raises(FFGymError, match=r"pip install 'ffgym\[minari\]'"):
        write_dataset("test-v0", gym.make(CIRCLES), [])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [({"n_episodes": 0}, "n_episodes"), ({"seed": -1}, "seed"), ({"info_keys": ("nothing",)}, "info key")],
)
def test_arguments_that_make_no_sense_are_refused(arguments, message):
    with pytest.raises(FFGymError, match=message):
        collect(gym.make(CIRCLES, horizon=1), **arguments)


def test_only_environments_of_ffgym_are_collected_from():
    with pytest.raises(FFGymError, match=r"gym\.make"):
        collect(gym.make_vec(CIRCLES))
    with pytest.raises(FFGymError, match="of ffgym"):
        collect(gym.make("CartPole-v1"))
