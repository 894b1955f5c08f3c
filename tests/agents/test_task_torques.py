"""Torques of given motions: found by what the motion is, and for no other."""

from dataclasses import replace

import gymnasium as gym
import numpy as np
import pytest

from ffgym.agents import LawAgent
from ffgym.agents.law_files import load_law, save_law
from ffgym.agents.task_torques import MotionTorque, TaskTorques
from ffgym.control import Window
from ffgym.core.errors import FFGymError
from ffgym.envs import EpisodeRecorder
from ffgym.recordings.metrics import motor_error
from ffgym.simulation import Run, simulate
from ffgym.studies import circle_references


@pytest.fixture(scope="module")
def references(arm):
    return list(circle_references(arm, ["p1"], [0.04, 0.1], [0.003]).values())


@pytest.fixture(scope="module")
def law(references):
    rng = np.random.default_rng(0)
    torques = [np.vstack([np.zeros(6), rng.normal(size=(len(r.t) - 1, 6))]) for r in references]
    return TaskTorques(
        tasks=tuple(MotionTorque(name=r.name, q=r.q, torque=u) for r, u in zip(references, torques, strict=True)),
        name="mine",
    )


def test_a_motion_is_known_by_what_it_is_and_not_by_its_name(law, references):
    for reference, task in zip(references, law.tasks, strict=True):
        again = replace(reference, name="something else", q=reference.q.copy())
        np.testing.assert_array_equal(law.torque(again), task.torque)


def test_another_motion_is_refused_even_under_a_known_name(law, references, arm):
    moved = replace(references[0], q=references[0].q + 2e-6)
    with pytest.raises(
        FFGymError, match=r"mine has no torque for the motion 'p1, 40 mm/s': it learned 'p1, 40 mm/s', "
    ):
        law.torque(moved)
    with pytest.raises(FFGymError, match="has no torque for the motion 'p2, 100 mm/s'"):
        law.task(circle_references(arm, ["p2"], [0.1], [0.003])["p2", 0.1])


def test_what_torque_returns_is_a_copy(law, references):
    law.torque(references[0])[:] = 7.0
    assert not (law.torque(references[0]) == 7.0).any()


def test_sample_by_sample_it_gives_its_task_and_after_the_end_the_last_torque(law, references):
    one = law.task(references[1])
    windows = Window.along(references[1], one.preview)
    memory = one.initial_memory(windows[0])
    for expected in one.torque(references[1])[1:]:
        torque, memory = one.step(memory, windows[int(memory[0])])
        np.testing.assert_array_equal(torque, expected)
    at_rest = replace(windows[-1], q=np.repeat(references[1].q[-1:], 2, axis=0))
    torque, _ = one.step(memory, at_rest)
    np.testing.assert_array_equal(torque, one.torque(references[1])[-1])


def test_several_tasks_begin_alike_so_that_one_must_be_chosen(law, references):
    window = Window.along(references[0], 1)[0]
    with pytest.raises(FFGymError, match=r"holds torques of 2 motions, .* choose one .* law\.task\(reference\)"):
        law.initial_memory(window)


def test_a_robot_that_is_elsewhere_is_named(law, references):
    one = law.task(references[1])
    windows = Window.along(references[1], 1)
    middle = len(references[1].t) // 2
    rows = np.array([middle, middle + 3])
    batch = replace(windows, q=windows.q[rows], motor_dq=windows.motor_dq[rows], motor_ddq=windows.motor_ddq[rows])
    one.step(np.array([[middle], [middle + 3.0]]), batch)
    with pytest.raises(FFGymError, match=f"at its sample {middle} the reference of robot 1 of the batch is elsewhere"):
        one.step(np.array([[middle], [float(middle)]]), batch)


def test_a_file_keeps_every_task(law, references, tmp_path):
    again = load_law(save_law(tmp_path / "law.npz", law))
    assert isinstance(again, TaskTorques)
    assert (again.name, [task.name for task in again.tasks]) == ("mine", [task.name for task in law.tasks])
    for reference in references:
        np.testing.assert_array_equal(again.torque(reference), law.torque(reference))


def test_tasks_of_no_robot_or_of_two_and_torques_of_another_length_are_refused(law):
    with pytest.raises(FFGymError, match="needs tasks of one robot, got none"):
        TaskTorques(tasks=())
    other = MotionTorque(name="one axis", q=np.zeros((5, 1)), torque=np.zeros((5, 1)))
    with pytest.raises(FFGymError, match="needs tasks of one robot, got 'p1, 40 mm/s', 'one axis'"):
        TaskTorques(tasks=(law.tasks[0], other))
    with pytest.raises(FFGymError, match=r"torque of task 'a' has shape \(4, 1\), must be \(5, 1\)"):
        MotionTorque(name="a", q=np.zeros((5, 1)), torque=np.zeros((4, 1)))


def test_an_agent_on_the_circle_path_does_what_the_law_does_in_a_simulation(arm, references):
    reference = references[1]
    swing = 0.3 * np.sin(2 * np.pi * 3 * reference.t)[:, None] * np.ones(6)
    law = TaskTorques(tasks=(MotionTorque(name="swing", q=reference.q, torque=swing),))
    recorder = EpisodeRecorder()
    env = gym.make_vec(
        "ffgym/CirclePath-v0",
        num_envs=2,
        positions=["p1"],
        speeds=[0.1],
        radii=[0.003],
        action_scale=10,
        recorder=recorder,
    )
    agent = LawAgent.for_env(law, env)
    observation, _ = env.reset(seed=0)
    memory = None
    while not recorder.recordings:
        action, memory = agent.predict(observation, memory)
        observation, *_ = env.step(action)
    (simulated,) = simulate([Run(reference=reference, law=law)], arm=arm)
    for recording in recorder.recordings:
        np.testing.assert_allclose(motor_error(recording), motor_error(simulated), rtol=0, atol=1e-8)
