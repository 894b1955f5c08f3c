"""Residual policies as files and as agents: what was trained is what runs."""

import subprocess
import sys
from dataclasses import replace

import gymnasium as gym
import numpy as np
import pytest

from ffgym.agents.artefacts import TRAINED
from ffgym.agents.elastic import elastic_feedforward
from ffgym.agents.law_agent import LawAgent
from ffgym.agents.law_files import pack, unpack
from ffgym.agents.residual.actor import LinearLayer
from ffgym.agents.residual.bases import BASES, base_law, base_named
from ffgym.agents.residual.environment import make_environment
from ffgym.agents.residual.policy import encode_policy, load_policy, save_policy
from ffgym.agents.residual.validation import base_errors, validate
from ffgym.control import Agent, ObservationLayout, Policy
from ffgym.core.errors import FFGymError
from ffgym.leaderboard.evaluation.closed_loop import run_rollouts
from ffgym.leaderboard.evaluation.jobs import score_circles
from ffgym.leaderboard.plants import find_plant
from ffgym.leaderboard.tasks import Task
from tests.agents.residual.residual_samples import policy_of, tiny

CIRCLE = "ffgym/CirclePath-v0"
MACHINE = '[machine]\ntitle = "a machine"\nrobot = "irb4600_60_205"\n'


@pytest.fixture(scope="module")
def env():
    own = {"action_scale": 30.0, "preview": 8, "horizon": 12}
    return gym.make_vec(CIRCLE, num_envs=3, autoreset_mode="SameStep", positions=["p1"], **own)


def test_a_policy_comes_back_bit_for_bit(tmp_path):
    policy = policy_of()
    path = save_policy(tmp_path / "policy.npz", policy)
    again = load_policy(path)
    assert encode_policy(again) == path.read_bytes() == encode_policy(policy)
    assert again.meta == {"seed": 5}
    assert path.stat().st_size < 10_000
    assert isinstance(again, Policy)


def test_running_a_policy_needs_neither_torch_nor_environments(tmp_path):
    path = save_policy(tmp_path / "policy.npz", policy_of())
    code = (
        "import sys; from ffgym.agents.residual.policy import load_policy; from ffgym.robot import load_robot\n"
        "from ffgym.control import ObservationLayout\n"
        f"policy, robot = load_policy({str(path)!r}), load_robot('irb4600_60_205')\n"
        "layout = ObservationLayout(robot, policy.preview, policy.action_scale * robot.friction.static)\n"
        "policy.agent(robot, layout)\n"
        "bad = ('torch', 'stable_baselines3', 'ffgym.envs', 'ffgym.workcell', 'ffgym.agents.catalogue')\n"
        "print([name for name in bad if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-W", "error", "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_a_policy_acts_as_in_its_training(irb4600):
    """Other paths, same numbers: over ends of episodes, with memory, from the environment of a training."""
    training = tiny(memory=2)
    trained_in = make_environment(training, horizon=9)
    plain = make_environment(training, horizon=9).venv
    policy = policy_of()
    agent = policy.agent(irb4600, plain.get_attr("observation_layout")[0])
    assert isinstance(agent, Agent)
    for each in (trained_in, plain):
        each.seed(4)
    features, observation = trained_in.reset(), plain.reset()
    actor, network = policy.actor, policy.actor.initial_state((2,))
    state, starts, ends = None, np.ones(2, dtype=bool), 0
    for _ in range(25):
        residual, network = actor.act(features, network, starts)
        action, state = agent.predict(observation, state, starts)
        np.testing.assert_array_equal(state.residual, residual)
        features, reward, starts, _ = trained_in.step(residual)
        observation, wanted, done, _ = plain.step(action)
        np.testing.assert_array_equal(reward, wanted)
        np.testing.assert_array_equal(done, starts)
        ends += starts.sum()
    assert ends == 4
    assert np.abs(residual).max() > 0.01


def test_a_silent_policy_is_its_base(env, irb4600):
    observation, _ = env.reset(seed=0)
    silent = policy_of(size=0.0)
    silent = replace(
        silent,
        actor=replace(
            silent.actor, layers=tuple(LinearLayer(weight=x.weight, bias=0 * x.bias) for x in silent.actor.layers)
        ),
    )
    law = base_law("lugre_dynamic", None, irb4600)
    base = LawAgent.for_env(law, env)
    agent = silent.agent(irb4600, env.unwrapped.observation_layout)
    state = memory = None
    for _ in range(8):
        action, state = agent.predict(observation, state)
        wanted, memory = base.predict(observation, memory)
        np.testing.assert_allclose(action, np.clip(wanted, -1, 1), rtol=0, atol=1e-15)
        observation, *_ = env.step(action)


@pytest.mark.parametrize("averaged", [True, False])
def test_a_policy_counts_errors_from_what_it_was_trained_on(env, irb4600, averaged):
    robot = irb4600.with_arm_share(np.full(6, 0.5))
    law, layout = base_law("elastic", None, robot), env.unwrapped.observation_layout
    agent = replace(policy_of(), base="elastic", averaged=averaged).agent(robot, layout)
    observation, _ = env.reset(seed=3)
    _, state = agent.predict(observation)
    # within a motion: from a memory that does not rest
    moving = np.random.default_rng(4).normal(size=state.memory.law.shape)
    _, state = agent.predict(observation, replace(state, memory=replace(state.memory, law=moving)))
    window = agent.composition.base.window(observation)
    own, instant = law.own_error(moving, window), law.instant_error(moving)
    np.testing.assert_array_equal(state.memory.own, own if averaged else instant)
    assert np.all(np.not_equal(own, instant))


def test_policies_that_ship_were_trained_on_errors_at_an_instant(tmp_path):
    shipped = load_policy(TRAINED / "ppo_drives" / "any" / "seed_0.npz")
    assert not shipped.averaged
    assert not load_policy(save_policy(tmp_path / "policy.npz", shipped)).averaged
    assert policy_of().averaged


def test_a_robot_alone_gets_what_it_gets_in_a_batch(env, irb4600):
    observation, _ = env.reset(seed=1)
    agent = policy_of().agent(irb4600, env.unwrapped.observation_layout)
    state, alone = None, None
    for _ in range(5):
        action, state = agent.predict(observation, state)
        own, alone = agent.predict(observation[1], alone)
        np.testing.assert_array_equal(own, action[1])
        observation, *_ = env.step(action)


def test_an_episode_that_begins_forgets_what_was(env, irb4600):
    observation, _ = env.reset(seed=2)
    agent = policy_of().agent(irb4600, env.unwrapped.observation_layout)
    fresh, _ = agent.predict(observation)
    _, state = agent.predict(observation[::-1])
    later, _ = agent.predict(observation, state)
    again, _ = agent.predict(observation, state, np.array([True, False, True]))
    np.testing.assert_array_equal(again[[0, 2]], fresh[[0, 2]])
    np.testing.assert_array_equal(again[1], later[1])
    assert np.any(later != fresh)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda header, arrays: header.update(kind="narx"), "Unknown kind of policy in .*policy.npz 'narx'"),
        (lambda header, arrays: header.pop("settings"), "holds no complete residual policy: 'settings'"),
        (lambda header, arrays: header["settings"].update(bound=-1.0), "bound of the residual = -1.0"),
        (lambda header, arrays: header["settings"].update(colour="red"), "settings .*colour.* must be"),
        (lambda header, arrays: header["settings"]["actor"].pop("layers"), "holds no complete residual policy"),
        (lambda header, arrays: arrays.pop("layer_1_bias"), "'layer_1_bias'"),
        (lambda header, arrays: arrays.update(layer_1_bias=np.zeros(4)), "bias of layer 1 has shape"),
    ],
)
def test_a_file_that_is_no_policy_is_one_clear_error(change, message, tmp_path):
    path = save_policy(tmp_path / "policy.npz", policy_of())
    header, arrays = unpack(path)
    change(header, arrays)
    path.write_bytes(pack(header, arrays))
    with pytest.raises(FFGymError, match=message):
        load_policy(path)


def test_a_damaged_or_missing_file_is_one_clear_error(tmp_path):
    path = save_policy(tmp_path / "policy.npz", policy_of())
    path.write_bytes(path.read_bytes()[:-100])
    for wrong in (path, tmp_path / "none.npz"):
        with pytest.raises(FFGymError, match=str(wrong)):
            load_policy(wrong)
    with pytest.raises(FFGymError, match=r"must end in .npz"):
        save_policy(tmp_path / "policy.zip", policy_of())


def test_environments_that_do_not_fit_are_refused(env, irb4600, one_axis):
    policy, layout = policy_of(), env.unwrapped.observation_layout
    with pytest.raises(FFGymError, match=r"8 samples ahead.*preview=8"):
        policy.agent(irb4600, ObservationLayout(irb4600, 4, irb4600.friction.static))
    with pytest.raises(FFGymError, match="A policy for 6 motors"):
        policy.agent(one_axis, ObservationLayout(one_axis, 8, one_axis.friction.static))
    agent = policy.agent(irb4600, layout)
    observation, _ = env.reset(seed=0)
    _, state = agent.predict(observation)
    for arguments, message in (
        ((observation[:, :5],), r"Observations must have .* got shape \(3, 5\)"),
        ((observation[:2], state), "The state of 3 robots is not what predict returned for 2"),
        ((observation, state, [True]), r"episode_start has shape \(1,\), must be \(3,\)"),
    ):
        with pytest.raises(FFGymError, match=message):
            agent.predict(*arguments)


def test_every_base_is_made_from_the_robot_alone_or_with_the_text_of_a_machine_file(irb4600, tmp_path):
    file = tmp_path / "machine.toml"
    file.write_text(MACHINE)
    for base in BASES:
        name, machine = base_named(f"model:{file}" if base == "model" else base)
        law = base_law(name, machine, irb4600)
        assert (law is None) == (base == "none")
        if base == "model":
            assert type(law) is type(elastic_feedforward(irb4600))
            assert machine == MACHINE


@pytest.mark.parametrize(
    ("base", "message"),
    [
        ("oracle", "Unknown base 'oracle'"),
        ("elastic:machine.toml", "Base 'elastic' takes no file"),
        ("model", "Base 'model' needs a machine file"),
        ("model:none.toml", "none.toml: cannot be read"),
        ("model:bad.toml", "bad.toml: it is not valid TOML"),
        ("model:other.toml", "other.toml is no machine file"),
        ("model:path.toml", "must name a built-in robot"),
    ],
)
def test_a_base_that_cannot_be_kept_is_refused(base, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bad.toml").write_text("[machine")
    (tmp_path / "other.toml").write_text("[friction]\n")
    (tmp_path / "path.toml").write_text(MACHINE.replace("irb4600_60_205", "mine.toml"))
    with pytest.raises(FFGymError, match=message):
        base_named(base)


def test_the_text_of_a_machine_file_goes_with_its_base_alone(irb4600):
    for base, machine in (("elastic", MACHINE), ("model", None)):
        with pytest.raises(FFGymError, match=f"Base '{base}' .* text of a machine file"):
            base_law(base, machine, irb4600)


@pytest.mark.slow
def test_a_silent_policy_gains_nothing_in_the_validation():
    silent = policy_of(size=0.0)
    layers = tuple(LinearLayer(weight=layer.weight, bias=0 * layer.bias) for layer in silent.actor.layers)
    base_errors.cache_clear()
    result = validate(replace(silent, actor=replace(silent.actor, layers=layers)), plants=1)
    assert result.policy.shape == (6,)
    assert result.log_ratio == 0
    assert validate(policy_of(), plants=1).log_ratio != 0
    assert base_errors.cache_info().misses == 1  # the base is run once


def test_policies_side_by_side_fly_as_each_does_alone():
    plant, seeds = find_plant("workcell:thesis"), [0, 4, 1]  # its sensors have noise
    tasks = [Task("p2", 0.1, (0.001,), "positions"), Task("p3", 0.1, (0.003,), "positions")]
    policies = [policy_of(seed=seed) for seed in (5, 6, 7)]
    flights = run_rollouts(plant, policies, tasks, seeds=seeds)
    for policy, seed, own in zip(policies, seeds, flights, strict=True):
        [alone] = run_rollouts(plant, [policy], tasks, seeds=[seed])
        for task, one, other in zip(tasks, own, alone, strict=True):
            assert one.actions.tobytes() == other.actions.tobytes()
            assert score_circles(task, one.recording) == score_circles(task, other.recording)
    assert flights[0][0].actions.tobytes() != flights[1][0].actions.tobytes()
