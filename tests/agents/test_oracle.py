"""The oracle knows each machine that is simulated, and nobody else does."""

from dataclasses import replace

import gymnasium as gym
import numpy as np
import pytest

from ffgym.agents import LawAgent
from ffgym.agents.catalogue import CATALOGUE
from ffgym.agents.declaration import AgentSetting
from ffgym.agents.elastic import elastic_feedforward
from ffgym.agents.oracle import OracleAgent, oracle_law
from ffgym.control import Window
from ffgym.core.errors import FFGymError
from ffgym.envs import EpisodeRecorder
from ffgym.envs.sb3 import make_sb3_env
from ffgym.recordings.metrics import path_errors
from ffgym.robot import RigidArm
from ffgym.simulation.plant.draws import PlantDistribution, with_payload
from ffgym.studies import circle_references

SHORT = {"positions": ["p1"], "speeds": [0.1], "radii": [0.003], "preview": 4, "action_scale": 60.0}
"""One circle in half a second."""


@pytest.fixture(scope="module")
def reference(arm):
    return circle_references(arm, ["p1"], speeds=(0.1,), radii=(0.003,))["p1", 0.1]


def run(env, agent, recorder):
    """Path error of the first episode of every sub-environment, in their order [mm]."""
    observation, state, start = env.reset(), None, np.ones(env.num_envs, bool)
    while len(recorder.recordings) < env.num_envs:
        action, state = agent.predict(observation, state, start)
        observation, _, start, _ = env.step(action)
    return [path_errors(recording)[0].rms * 1e3 for recording in recorder.recordings[: env.num_envs]]


def test_on_a_nominal_machine_it_is_the_elastic_law(irb4600, reference):
    oracle = CATALOGUE["oracle"].make(AgentSetting.of(irb4600))
    elastic = CATALOGUE["elastic"].make(AgentSetting.of(irb4600))
    np.testing.assert_array_equal(oracle.torque(reference), elastic.torque(reference))
    assert (oracle.name, elastic.name) == ("oracle", "elastic")


def test_it_alone_is_made_with_the_true_machine(irb4600, arm, reference):
    loaded = with_payload(irb4600, 5.0)
    setting = replace(AgentSetting.of(irb4600), truth=loaded)
    elastic, oracle = (CATALOGUE[name].make(setting).torque(reference) for name in ("elastic", "oracle"))
    np.testing.assert_array_equal(oracle, oracle_law(loaded, arm).torque(reference))
    np.testing.assert_array_equal(elastic, elastic_feedforward(irb4600).torque(reference))
    assert np.abs(oracle - elastic).max() > 0.1
    assert CATALOGUE["oracle"].track == "oracle"


def test_a_model_from_a_file_keeps_the_controller_of_the_machine(irb4600, arm, reference):
    loaded = RigidArm(with_payload(irb4600, 5.0))
    setting = replace(AgentSetting.of(irb4600), arm=loaded, controller=arm, truth=irb4600)
    law = CATALOGUE["elastic"].make(setting)
    np.testing.assert_array_equal(law.torque(reference), oracle_law(loaded.robot, arm).torque(reference))
    oracle = CATALOGUE["oracle"].make(setting)
    np.testing.assert_allclose(oracle.torque(reference), elastic_feedforward(irb4600).torque(reference), atol=1e-12)


def test_on_machines_that_differ_it_leaves_a_tenth_of_what_the_nominal_law_leaves():
    found = {}
    for make in (OracleAgent.for_env, lambda env: LawAgent.for_env(elastic_feedforward("irb4600_60_205"), env)):
        recorder = EpisodeRecorder()
        env = make_sb3_env(
            "ffgym/CirclePath-v0", 3, **SHORT, randomization=PlantDistribution(), recorder=recorder, horizon=None
        )
        env.seed(3)
        found[make] = np.array(run(env, make(env), recorder))
    oracle, elastic = found.values()
    assert np.mean(oracle) < 0.1 * np.mean(elastic)
    assert np.all(oracle < elastic)


def test_it_sees_every_new_machine_when_its_episode_begins(irb4600, arm):
    env = gym.make("ffgym/CirclePath-v0", **SHORT)
    agent = OracleAgent.for_env(env)
    scale, state = env.unwrapped.action_torque, None
    for robot in (irb4600, with_payload(irb4600, 5.0), irb4600):
        observation, _ = env.reset(seed=0, options={"plant": robot})
        law, start = oracle_law(robot, arm), True
        windows = Window.along(env.unwrapped.core.motions[0].reference, law.preview)
        memory = law.initial_memory(windows[0])
        for k in range(90):
            action, state = agent.predict(observation, state, np.array(start))
            torque, memory = law.step(memory, windows[k])
            np.testing.assert_allclose(action * scale, torque, atol=1e-9)
            observation, start = env.step(action)[0], False
    assert len(agent._agents) == 1  # and it forgets those that are gone


def test_a_batch_acts_as_each_sub_environment_alone():
    def actions(n, seed):
        env = make_sb3_env("ffgym/CirclePath-v0", n, **SHORT, randomization=PlantDistribution())
        env.seed(seed)  # sub-environment i gets seed + i
        agent, observation, state, start = OracleAgent.for_env(env), env.reset(), None, np.ones(n, bool)
        out = []
        for _ in range(90):
            action, state = agent.predict(observation, state, start)
            out.append(action)
            observation, _, start, _ = env.step(action)
        return np.array(out)

    together = actions(3, 11)
    for row in range(3):
        np.testing.assert_allclose(actions(1, 11 + row)[:, 0], together[:, row], atol=1e-12)


def test_observations_of_a_part_of_the_batch_are_refused():
    env = gym.make_vec("ffgym/CirclePath-v0", num_envs=3, **SHORT)
    observation, _ = env.reset(seed=0)
    with pytest.raises(FFGymError, match="needs the observations of all 3 sub-environments, 2 are given"):
        OracleAgent.for_env(env).predict(observation[:2])
