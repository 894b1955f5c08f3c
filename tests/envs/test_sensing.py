"""What an agent sees of the motor angle: resolution, noise, backward differences; the servo sees the angle itself."""

import gymnasium as gym
import numpy as np
import pytest

from ffgym.envs import EpisodeRecorder, Sensing
from ffgym.simulation import Resolver
from tests.envs.env_samples import CIRCLE, ONE_AXIS, actions_for, plant_state

CIRCLE_OPTIONS = {"position": "p1", "speed": 0.1, "radii": 0.001}


def measured(env, observations):
    """Motor angle [rad] and speed [rad/s] that observations speak of, shape (T, N) each."""
    layout = env.unwrapped.observation_layout
    ratio = env.unwrapped.core.robot.drive.gear_ratio
    angle = layout.read(observations, "reference_position") * ratio - layout.read(observations, "error")
    return angle, layout.read(observations, "reference_velocity") - layout.read(observations, "error_rate")


def episode(name, steps, seed=0, options=None, **kwargs):
    """Environment and observations (T + 1, D) of an episode with random actions."""
    env = gym.make(name, horizon=steps, **kwargs)
    observations = [env.reset(seed=seed, options=options)[0]]
    actions = actions_for(steps, 1, env.action_space.shape[0])[:, 0]
    observations += [env.step(action)[0] for action in actions]
    return env, np.array(observations)


@pytest.mark.parametrize("bits", [8, 16])
@pytest.mark.parametrize(("name", "options"), [(CIRCLE, CIRCLE_OPTIONS), (ONE_AXIS, {"frequency": 1.0})])
def test_an_encoder_sees_what_a_resolver_records_at_control_samples(name, options, bits):
    recorder = EpisodeRecorder(record_dt=0.004, sensors=[Resolver(bits=bits)])
    env, observations = episode(name, 120, options=options, recorder=recorder, sensing=Sensing(encoder_bits=bits))
    angle, speed = measured(env, observations)
    (recording,) = recorder.recordings
    step = 2 * np.pi / 2**bits
    np.testing.assert_allclose(angle, recording.joint_array("motor.position"), rtol=0, atol=1e-9)
    np.testing.assert_allclose(angle / step, np.round(angle / step), rtol=0, atol=1e-5)
    np.testing.assert_allclose(speed[1:], recording.joint_array("motor.velocity")[1:], rtol=0, atol=1e-6)
    np.testing.assert_allclose(speed[0], env.unwrapped.core.motions[0].reference.motor_dq[0], rtol=0, atol=1e-9)
    assert np.abs(angle).max() > 10 * step


def test_an_agent_sees_the_true_angle_and_speed_by_default():
    recorder = EpisodeRecorder(record_dt=0.004)
    env, observations = episode(CIRCLE, 120, options=CIRCLE_OPTIONS, recorder=recorder)
    angle, speed = measured(env, observations)
    np.testing.assert_allclose(angle, recorder.recordings[0].joint_array("motor.position"), rtol=0, atol=1e-12)
    np.testing.assert_allclose(speed, recorder.recordings[0].joint_array("motor.velocity"), rtol=0, atol=1e-12)


@pytest.mark.parametrize("sensing", [Sensing(encoder_bits=6), Sensing(noise=0.1), Sensing(encoder_bits=9, noise=1.0)])
def test_what_the_agent_sees_changes_neither_servo_nor_physics_nor_reward(sensing):
    exact, coarse = (gym.make(CIRCLE, sensing=s) for s in (Sensing(), sensing))
    one, two = (env.reset(seed=0, options=CIRCLE_OPTIONS)[0] for env in (exact, coarse))
    for action in actions_for(30, 1, 6)[:, 0]:
        (one, *rest), (two, *same) = exact.step(action), coarse.step(action)
        assert rest[:3] == same[:3]
        for key, value in rest[3].items():
            np.testing.assert_array_equal(value, same[3][key])
    assert not np.array_equal(one, two)
    np.testing.assert_array_equal(plant_state(exact), plant_state(coarse))


def test_noise_is_white_and_as_large_as_it_says():
    size = 0.02
    recorder = EpisodeRecorder(record_dt=0.004)
    env, observations = episode(ONE_AXIS, 2000, recorder=recorder, sensing=Sensing(noise=size))
    angle, speed = (column[:, 0] for column in measured(env, observations))
    noise = angle - recorder.recordings[0].joint_array("motor.position")[:, 0]
    assert abs(noise.mean()) < 4 * size / np.sqrt(2000)
    assert noise.std() == pytest.approx(size, rel=0.08)  # 5 standard deviations of the estimate
    assert abs(np.corrcoef(noise[1:], noise[:-1])[0, 1]) < 0.1
    np.testing.assert_allclose(speed[1:], np.diff(angle) / 0.004, rtol=0, atol=1e-6)
    assert speed[0] == pytest.approx(env.unwrapped.core.motions[0].reference.motor_dq[0, 0])  # no difference yet


def test_an_encoder_with_noise_still_tells_whole_steps():
    env, observations = episode(ONE_AXIS, 50, sensing=Sensing(encoder_bits=10, noise=0.01))
    steps = measured(env, observations)[0] / (2 * np.pi / 2**10)
    np.testing.assert_allclose(steps, np.round(steps), rtol=0, atol=1e-6)


def test_noise_follows_the_seed_and_not_the_neighbours():
    sensing = Sensing(noise=0.01)
    batch = gym.make_vec(ONE_AXIS, num_envs=3, sensing=sensing, autoreset_mode="SameStep", horizon=5)
    single = gym.make(ONE_AXIS, sensing=sensing, horizon=5)
    np.testing.assert_array_equal(batch.reset(seed=7)[0][1], single.reset(seed=8)[0])
    for k in range(12):
        one = batch.step(np.zeros((3, 1)))[0][1]
        two = single.step([0.0])[0]
        if k % 5 == 4:
            two = single.reset()[0]
        np.testing.assert_array_equal(one, two)
    other = gym.make(ONE_AXIS, sensing=sensing).reset(seed=9)[0]
    assert not np.array_equal(other[0], single.reset(seed=8)[0][0])


def test_each_sub_environment_has_its_own_sensors_for_one_episode():
    env = gym.make_vec(ONE_AXIS, num_envs=3, autoreset_mode="SameStep", horizon=6)
    own = [{}, {"sensing": Sensing(encoder_bits=8)}, {"sensing": Sensing(noise=0.1)}]
    shared = {"frequency": 1.0}
    env.reset(seed=0, options={"each": [shared | each for each in own]})
    for k in range(6):
        observation, *_, info = env.step(np.zeros((3, 1)))
        seen = np.stack(list(info["final_obs"])) if k == 5 else observation
        exact = env.observation_layout.read(seen, "error")[0]
        assert len({float(x) for x in seen[:, 0]}) == 3
    assert np.isfinite(exact).all()
    env.reset(options=shared)
    observation, *_ = env.step(np.zeros((3, 1)))
    np.testing.assert_array_equal(observation, np.tile(observation[:1], (3, 1)))  # all exact again


def test_the_first_speed_of_an_episode_is_true_and_does_not_look_back_into_the_last_one():
    env = gym.make(ONE_AXIS, sensing=Sensing(encoder_bits=12), horizon=30)
    for seed in (0, None):
        observation, _ = env.reset(seed=seed)
        assert env.unwrapped.observation_layout.read(observation, "error_rate") == pytest.approx(0.0, abs=1e-12)
        for _ in range(30):
            env.step([1.0])


def test_a_partial_reset_takes_no_new_sample_of_the_others():
    env = gym.make_vec(ONE_AXIS, num_envs=2, sensing=Sensing(noise=0.1), autoreset_mode="Disabled")
    env.reset(seed=0)
    observation, *_ = env.step(np.zeros((2, 1)))
    again, _ = env.reset(options={"reset_mask": np.array([True, False])})
    np.testing.assert_array_equal(again[1], observation[1])
    twin = gym.make_vec(ONE_AXIS, num_envs=2, sensing=Sensing(noise=0.1), autoreset_mode="Disabled")
    twin.reset(seed=0)
    twin.step(np.zeros((2, 1)))
    one, two = (e.step(np.zeros((2, 1)))[0] for e in (env, twin))
    np.testing.assert_array_equal(one[1], two[1])  # nor has it used up any of their noise


def test_what_is_drawn_next_does_not_depend_on_how_long_noise_was_drawn():
    following = []
    for steps in (3, 30):
        env = gym.make(CIRCLE, sensing=Sensing(noise=0.01))
        env.reset(seed=4)
        for _ in range(steps):
            env.step(np.zeros(6))
        following.append([env.reset()[0], env.unwrapped.core.motions[0].label])
    np.testing.assert_array_equal(following[0][0], following[1][0])
    assert following[0][1] == following[1][1]
