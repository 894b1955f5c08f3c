"""The environment is the simulation: the same physics, controller and interpolation, bit for bit."""

import gymnasium as gym
import numpy as np
import pytest

from ffgym.control import DynamicLuGreExact, NoCompensation, StaticLuGre
from ffgym.envs import EpisodeRecorder, ResidualAction
from ffgym.paths import joint_reference, joint_sine
from ffgym.robot import load_robot
from ffgym.simulation import Run, simulate
from ffgym.studies import circle_references


def episode(name, options, law=None, **kwargs):
    """Recording of an episode with zero actions on top of a law."""
    recorder = EpisodeRecorder()
    layers = () if law is None else (ResidualAction(law),)
    env = gym.make(name, recorder=recorder, layers=layers, action_scale=30.0, **kwargs)
    env.reset(seed=0, options=options)
    ended = False
    while not ended:
        _, _, terminated, truncated, _ = env.step(np.zeros(env.action_space.shape))
        ended = terminated or truncated
    (recording,) = recorder.recordings
    return recording


def assert_same_columns(one, two):
    assert one.columns.keys() == two.columns.keys()
    for name in one.columns:
        np.testing.assert_array_equal(one[name], two[name], err_msg=name)
    assert one.header.phases == two.header.phases
    assert one.header.provenance["physics_fingerprint"] == two.header.provenance["physics_fingerprint"]


@pytest.mark.parametrize("law", [None, NoCompensation, StaticLuGre, DynamicLuGreExact])
def test_the_circle_test_equals_the_simulation(irb4600, arm, law):
    law = law() if law in (None, NoCompensation) and law else law and law(irb4600.friction)
    (reference,) = circle_references(arm, ["p3"], [0.04], [0.001]).values()
    (simulated,) = simulate([Run(reference=reference, **({"law": law} if law else {}))], arm=arm)
    acted = episode("ffgym/CirclePath-v0", {"position": "p3", "speed": 0.04, "radii": 0.001}, law)
    exact = law is None or isinstance(law, NoCompensation)
    if exact:
        assert_same_columns(acted, simulated)
    for name in simulated.columns:  # an action is torque / scale, which rounds
        np.testing.assert_allclose(acted[name], simulated[name], rtol=0, atol=1e-9, err_msg=name)


@pytest.mark.parametrize("frequency", [1.0, 3.0])
def test_the_one_axis_test_equals_the_simulation(one_axis, frequency):
    reference = joint_reference(one_axis, joint_sine([1.0], frequency, 10.0, name=f"sine {frequency:g} Hz"))
    (simulated,) = simulate([Run(reference=reference)])
    assert_same_columns(episode("ffgym/OneAxis-v0", {"frequency": frequency}), simulated)


def test_an_episode_that_ends_early_gives_the_beginning_of_the_recording():
    options = {"position": "p1", "speed": 0.1}
    whole = episode("ffgym/CirclePath-v0", options)
    part = episode("ffgym/CirclePath-v0", options, horizon=150)
    np.testing.assert_array_equal(part.t, whole.t[: 150 * 4 + 1])
    for name in part.columns:
        np.testing.assert_array_equal(part[name], whole[name][: len(part)], err_msg=name)
    assert part.header.phases[-1].end <= part.t[-1] + 0.001 + 1e-9


def test_info_agrees_with_the_recording():
    recorder = EpisodeRecorder()
    env = gym.make("ffgym/CirclePath-v0", recorder=recorder, horizon=260)
    env.reset(seed=0, options={"position": "p2", "speed": 0.1})
    infos = [env.step(np.full(6, 0.1))[-1] for _ in range(260)]
    recording = recorder.recordings[0]
    at_samples = slice(4, None, 4)
    for key, family in {"u_c": "feedback.effort", "u_i": "feedback.integral"}.items():
        np.testing.assert_allclose(
            [info[key] for info in infos], recording.joint_array(family)[at_samples], rtol=0, atol=1e-12
        )
    np.testing.assert_allclose([i["u_p"] for i in infos], [i["u_c"] - i["u_i"] for i in infos], atol=1e-12)
    np.testing.assert_allclose([i["tcp"] for i in infos], recording.vector("tcp.position")[at_samples], atol=1e-12)
    np.testing.assert_allclose([i["time"] for i in infos], recording.t[at_samples])
    kinds = [next(p.kind for p in recording.header.phases if p.start <= t < p.end) for t in recording.t[at_samples]]
    assert [info["phase"] for info in infos] == kinds
    assert {"standstill", "lead_in", "circle", "lead_out"} <= set(kinds)


def test_the_one_axis_robot_is_the_built_in_one():
    assert gym.make("ffgym/OneAxis-v0").unwrapped.core.robot.name == load_robot("one_axis").name
