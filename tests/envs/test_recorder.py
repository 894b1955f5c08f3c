"""Finished episodes become recordings, each of its own sub-environment, whole and in order."""

import gymnasium as gym
import numpy as np
import pytest

from ffgym.envs import EpisodeRecorder, Hold, LowPassAction, ResidualAction
from ffgym.simulation import LaserTracker, Resolver
from tests.envs.env_samples import CIRCLE, ONE_AXIS, Remembering, actions_for, plant_state

CIRCLE_OPTIONS = {"position": "p1", "speed": 0.1, "radii": 0.001}


def played(actions, recorder=None, mode="SameStep", **kwargs):
    """Recorder and infos of a vector environment after `actions` (T, B, N)."""
    recorder = recorder or EpisodeRecorder()
    env = gym.make_vec(ONE_AXIS, num_envs=actions.shape[1], recorder=recorder, autoreset_mode=mode, **kwargs)
    env.reset(seed=0)
    infos = [env.step(action)[-1] for action in actions]
    return recorder, infos


@pytest.mark.parametrize("mode", ["SameStep", "NextStep"])
def test_every_episode_of_every_sub_environment_is_recorded_as_if_alone(mode):
    horizon, n = 6, 3
    actions = actions_for(21 if mode == "NextStep" else 18, n)
    recorder, _ = played(actions, mode=mode, horizon=horizon)
    assert len(recorder.recordings) == 3 * n
    for i in range(n):
        alone = EpisodeRecorder()
        env = gym.make(ONE_AXIS, recorder=alone, horizon=horizon)
        env.reset(seed=i)
        for k, action in enumerate(actions[:, i]):
            if mode == "NextStep" and k % 7 == 6:  # the step that begins anew
                env.reset()
                continue
            ended = env.step(action)[3]
            if ended and mode == "SameStep":
                env.reset()
        for one, two in zip(alone.recordings, recorder.recordings[i::n], strict=True):
            assert one.columns.keys() == two.columns.keys()
            for name in one.columns:
                np.testing.assert_array_equal(one[name], two[name], err_msg=name)


def test_added_torque_is_what_was_applied_whatever_the_layers():
    layers = [LowPassAction(30.0), ResidualAction(Remembering()), Hold(3)]
    recorder = EpisodeRecorder(record_dt=0.004)
    env = gym.make(ONE_AXIS, recorder=recorder, layers=layers, horizon=12)
    env.reset(seed=0)
    applied = [0.0]
    step = env.unwrapped.core.step

    def watched(action, active=None):
        applied.append(float(action[0, 0]))
        return step(action, active)

    env.unwrapped.core.step = watched
    for action in (0.5, -0.3, 0.9, 2.0):
        env.step([action])
    (recording,) = recorder.recordings
    torque = recording["compensation.effort.j1"]
    np.testing.assert_allclose(torque, np.clip(applied, -1, 1) * env.unwrapped.action_torque[0], rtol=1e-12)


def test_an_unfinished_episode_is_dropped_by_a_reset_and_does_not_leak_into_the_next():
    recorder = EpisodeRecorder(record_dt=0.004)
    env = gym.make(ONE_AXIS, recorder=recorder, horizon=5)
    env.reset(seed=0)
    for _ in range(3):
        env.step([1.0])
    env.reset(seed=0)
    assert recorder.recordings == []
    for _ in range(5):
        env.step([0.0])
    (recording,) = recorder.recordings
    assert len(recording) == 6
    np.testing.assert_array_equal(recording.t, 0.004 * np.arange(6))


@pytest.mark.parametrize("record_dt", [0.00025, 0.001, 0.004])
def test_samples_are_taken_at_the_sample_time(record_dt):
    recorder, _ = played(np.zeros((5, 1, 1)), EpisodeRecorder(record_dt=record_dt), horizon=5)
    (recording,) = recorder.recordings
    assert recording.dt == pytest.approx(record_dt)
    assert recording.t[-1] == pytest.approx(0.02)
    fine, _ = played(np.zeros((5, 1, 1)), EpisodeRecorder(record_dt=0.00025), horizon=5)
    every = round(record_dt / 0.00025)
    name = "motor.position.j1"
    np.testing.assert_array_equal(recording[name], fine.recordings[0][name][::every])


def test_recording_changes_no_bit_of_the_physics():
    states = []
    for recorder in (None, EpisodeRecorder()):
        env = gym.make_vec(ONE_AXIS, num_envs=2, recorder=recorder, horizon=8)
        env.reset(seed=0)
        for action in actions_for(12, 2):
            env.step(action)
        states.append(plant_state(env))
    np.testing.assert_array_equal(*states)


def test_an_emergency_stop_is_recorded_up_to_the_stop():
    recorder = EpisodeRecorder(record_dt=0.004)
    env = gym.make(ONE_AXIS, recorder=recorder, error_limit=0.02, action_scale=10.0)
    env.reset(seed=0)
    steps, terminated = 0, False
    while not terminated:
        _, _, terminated, _, _ = env.step([1.0])
        steps += 1
    (recording,) = recorder.recordings
    assert len(recording) == steps + 1
    error = recording["reference.position.j1"] - recording["motor.position.j1"]  # the gear ratio is 1
    assert np.abs(error[-1]) > 0.02
    assert (np.abs(error[:-1]) <= 0.02).all()


def test_the_last_few_are_kept_and_every_one_is_handed_over():
    seen = []
    recorder, _ = played(np.zeros((8, 2, 1)), EpisodeRecorder(keep=3, on_episode=seen.append), horizon=2)
    assert len(seen) == 8
    assert recorder.recordings == seen[-3:]
    recorder, _ = played(np.zeros((8, 2, 1)), EpisodeRecorder(keep=0), horizon=2)
    assert recorder.recordings == []


def test_an_episode_that_still_runs_can_be_looked_at():
    recorder = EpisodeRecorder(record_dt=0.004)
    env = gym.make(ONE_AXIS, recorder=recorder)
    env.reset(seed=0)
    for k in range(3):
        env.step([0.1])
        assert len(recorder.recording(env.unwrapped.core, 0)) == k + 2
    assert recorder.recordings == []


def test_sensors_measure_and_hide_what_no_machine_knows():
    exact, sensed = EpisodeRecorder(), EpisodeRecorder(
        sensors=[Resolver(bits=12), LaserTracker(noise=1e-5, period=0.001)], seed=3
    )  # fmt: skip
    for recorder in (exact, sensed):
        env = gym.make(CIRCLE, recorder=recorder, horizon=20)
        env.reset(seed=0, options=CIRCLE_OPTIONS)
        for _ in range(20):
            env.step(np.zeros(6))
    one, two = exact.recordings[0], sensed.recordings[0]
    assert any(name.startswith("friction.effort") for name in one.columns)
    assert not any(name.startswith(("friction.effort", "link.position")) for name in two.columns)
    noise = one.vector("tcp.position") - two.vector("tcp.position")
    assert noise.std() == pytest.approx(1e-5, rel=0.3)
    steps = two.joint_array("motor.position") / (2 * np.pi / 2**12)
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-6)
