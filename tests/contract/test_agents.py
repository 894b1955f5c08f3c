"""The same questions to every member of the catalogue; a new one is picked up by itself."""

import re
from dataclasses import replace
from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest

import ffgym  # noqa: F401 - registers the environments
from ffgym.agents import LawAgent
from ffgym.agents.catalogue import CATALOGUE, make_law
from ffgym.agents.declaration import AgentSetting
from ffgym.agents.law_files import StoredLaw, load_law, save_law
from ffgym.control import CausalLaw, Window
from ffgym.core.errors import FFGymError
from ffgym.envs import EpisodeRecorder
from ffgym.recordings.metrics import motor_error
from ffgym.robot import RigidArm
from ffgym.simulation import Run, simulate
from ffgym.studies import circle_references, sine_references

DOCS = Path(__file__).parents[2] / "docs" / "agents"
ON_ONE_AXIS = [name for name, entry in CATALOGUE.items() if not entry.needs_arm]
CAUSAL = [name for name in ON_ONE_AXIS if name != "none"]
LEARNS_AT_LENGTH = {name for name, entry in CATALOGUE.items() if entry.track == "causal" or entry.package}
"""On six axes these learn from motions that take minutes of robot time."""
WHOLE_MOTION = {"ilc_basis"}
"""Need the whole motion beforehand."""
ON_SIX_AXES = [
    pytest.param(name, marks=[pytest.mark.slow] * (name in LEARNS_AT_LENGTH)) for name in CATALOGUE if name != "none"
]


@pytest.fixture(scope="module")
def sines(one_axis):
    """References of the sine test, by frequency [Hz]."""
    return sine_references(one_axis)


@pytest.fixture(scope="module")
def make(one_axis, sines):
    """Function of a name that returns the law for one axis, made once."""
    made = {}

    def law(name):
        if name not in made:
            made[name] = make_law(name, AgentSetting.of(one_axis, references=[sines[1.0]]))
        return made[name]

    return law


@pytest.mark.parametrize("name", ON_ONE_AXIS)
def test_a_law_has_the_name_of_its_entry_and_gives_finite_torque(make, sines, name):
    law = make(name)
    torque = law.torque(sines[1.0])
    assert law.name == name
    assert torque.shape == sines[1.0].q.shape
    assert np.isfinite(torque).all()
    assert (name == "none") == (not torque.any())


@pytest.mark.parametrize("name", CAUSAL)
def test_sample_by_sample_is_the_same_law_as_all_at_once(make, sines, name):
    check_samples(make(name), sines[1.0])


@pytest.mark.parametrize("name", CAUSAL)
def test_a_batch_is_the_same_as_its_rows_one_by_one(make, sines, name):
    check_batch(make(name), sines[1.0])


@pytest.mark.parametrize("name", ON_ONE_AXIS)
def test_motions_side_by_side_have_the_same_bits_as_each_alone(make, sines, name):
    check_side_by_side(make(name), [sines[1.0]] if CATALOGUE[name].track == "per task" else list(sines.values()))


@pytest.mark.parametrize("name", ON_SIX_AXES)
def test_on_six_axes_too_samples_and_batches_are_the_same_law(arm, name):
    circle = circle_references(arm, ["p1"], [0.1], [0.003])["p1", 0.1]
    law = make_law(name, AgentSetting.of(arm.robot, references=[circle]))
    shorter = (
        [circle] if CATALOGUE[name].track == "per task" else [*circle_references(arm, ["p2"], [0.1], [0.001]).values()]
    )
    check_side_by_side(law, [*shorter, circle])
    assert law.torque(circle).any(axis=0).all()
    if name not in WHOLE_MOTION:
        check_samples(law, circle)
        check_batch(law, circle)


def check_side_by_side(law, references):
    together = law.torques_along([*references, references[0]])
    alone = [law.torque(reference) for reference in references]
    for torque, single in zip(together, [*alone, alone[0]], strict=True):
        assert torque.tobytes() == single.tobytes()


def check_samples(law, reference):
    windows = Window.along(reference, law.preview)
    memory = law.initial_memory(windows[0])
    whole = law.torque(reference)
    for k in range(len(reference.t) - 1):
        torque, memory = law.step(memory, windows[k])
        np.testing.assert_allclose(torque, whole[k + 1], rtol=0, atol=1e-12 * max(1, np.abs(whole).max()))


def check_batch(law, reference):
    assert isinstance(law, CausalLaw)
    windows = Window.along(reference, law.preview)
    per_task = CATALOGUE[law.name].track == "per task"
    starts = (0, 0, 0) if per_task else (0, 37, 101)  # the learned task begins at its beginning

    def take(rows):
        return replace(windows, q=windows.q[rows], motor_dq=windows.motor_dq[rows], motor_ddq=windows.motor_ddq[rows])

    together = law.initial_memory(take(list(starts)))
    alone = [law.initial_memory(windows[start]) for start in starts]
    for k in range(60):
        torques, together = law.step(together, take([start + k for start in starts]))
        for i, start in enumerate(starts):
            torque, alone[i] = law.step(alone[i], windows[start + k])
            np.testing.assert_allclose(torques[i], torque, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(together, np.stack(alone), rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("name", [name for name in ON_ONE_AXIS if CATALOGUE[name].track != "causal"])
def test_making_a_law_again_gives_the_same_bits(make, one_axis, sines, name):
    again = make_law(name, AgentSetting.of(one_axis, references=[sines[1.0]], n_threads=2))
    np.testing.assert_array_equal(again.torque(sines[1.0]), make(name).torque(sines[1.0]))


@pytest.mark.parametrize("name", [name for name in ON_ONE_AXIS if CATALOGUE[name].track == "causal"])
def test_what_may_not_know_the_model_is_the_same_with_a_wrong_one_each_time(make, one_axis, sines, name):
    own = AgentSetting.of(one_axis, references=[sines[1.0]], n_threads=2)
    wrong = replace(one_axis, friction=one_axis.friction.scale(coulomb=2.0, static=2.0, viscous=0.5))
    law = make_law(name, replace(own, arm=RigidArm(wrong), controller=own.arm, truth=one_axis))
    np.testing.assert_array_equal(law.torque(sines[1.0]), make(name).torque(sines[1.0]))


@pytest.mark.parametrize("name", CAUSAL)
def test_an_agent_in_the_environment_does_what_its_law_does_in_a_simulation(make, sines, name):
    law, recorder = make(name), EpisodeRecorder()
    env = gym.make_vec(
        "ffgym/OneAxis-v0", num_envs=2, frequencies=[1.0], preview=law.preview, action_scale=30, recorder=recorder
    )
    agent = LawAgent.for_env(law, env)
    observation, _ = env.reset(seed=0)
    memory, starts = None, np.ones(2, dtype=np.bool_)
    while not recorder.recordings:
        action, memory = agent.predict(observation, memory, starts)
        observation, _, terminated, truncated, _ = env.step(action)
        starts = terminated | truncated
    (simulated,) = simulate([Run(reference=sines[1.0], law=law)])
    for recording in recorder.recordings:
        np.testing.assert_allclose(motor_error(recording), motor_error(simulated), rtol=0, atol=1e-9)


@pytest.mark.parametrize("name", CAUSAL)
def test_an_agent_forgets_where_an_episode_begins_and_nowhere_else(make, name):
    law = make(name)
    env = gym.make("ffgym/OneAxis-v0", frequencies=[1.0], preview=law.preview, action_scale=30)
    agent = LawAgent.for_env(law, env)
    first, _ = env.reset(seed=0)
    start, memory = agent.predict(first)
    second = env.step(start)[0]
    after, memory = agent.predict(second, memory, np.array(False))
    if CATALOGUE[name].track != "per task":  # which runs its own task only, from the beginning
        batch, _ = agent.predict(np.stack([first, second]), np.stack([memory, memory]), np.array([True, False]))
        np.testing.assert_allclose(batch[0], start, rtol=0, atol=1e-12)
    assert after.shape == start.shape == (1,)


def test_an_agent_refuses_observations_and_states_of_others(make):
    env = gym.make_vec("ffgym/OneAxis-v0", num_envs=3, preview=4, action_scale=30)
    agent = LawAgent.for_env(make("elastic"), env)
    observation, _ = env.reset(seed=0)
    _, state = agent.predict(observation)
    with pytest.raises(FFGymError, match=r"Observations must have \d+ numbers each, .* got shape \(3, 5\)"):
        agent.predict(observation[:, :5])
    with pytest.raises(FFGymError, match=r"The state of shape \(3, 11\) is not what predict returned"):
        agent.predict(observation[:2], state)


@pytest.mark.parametrize("name", CAUSAL)
def test_a_law_for_one_axis_refuses_a_robot_with_six(make, arm, name):
    reference = circle_references(arm, ["p1"], [0.1], [0.001])["p1", 0.1]
    with pytest.raises(ValueError, match=r"for 1 joint|motion"):
        make(name).torque(reference)


@pytest.mark.parametrize("name", CAUSAL)
def test_a_stored_law_comes_back_bit_for_bit(make, sines, tmp_path, name):
    law = make(name)
    if not isinstance(law, StoredLaw):
        assert "nominal parameters" in CATALOGUE[name].track or CATALOGUE[name].track == "oracle"  # learned nothing
        return
    again = load_law(save_law(tmp_path / "law.npz", law))
    assert again.name == law.name
    np.testing.assert_array_equal(again.torque(sines[1.0]), law.torque(sines[1.0]))


def test_every_member_has_words_and_a_look_of_its_own():
    pytest.importorskip("ffgym.report")
    from ffgym.report import law_styles

    styles = law_styles([*CATALOGUE, "my_law", "another"]).values()
    assert len({style.label for style in styles}) == len(styles)
    assert len({(style.colour, style.line) for style in styles}) == len(styles)
    assert not any(name.replace("_", " ") == law_styles([name])[name].label for name in CATALOGUE)


@pytest.mark.parametrize("name", list(CATALOGUE))
def test_every_member_is_documented(name):
    text = (DOCS / CATALOGUE[name].page).read_text(encoding="utf-8")
    assert f"`{name}`" in text
    if name != "none":
        headings = re.findall(r"^## (.*)$", text, flags=re.M)
        for heading in ("Run it", "Logged", "Departures from the source", "Results"):
            assert heading in headings, f"{CATALOGUE[name].page} lacks '## {heading}'"
        assert re.search(r"^(ffgym|python -m) ", text, flags=re.M)
