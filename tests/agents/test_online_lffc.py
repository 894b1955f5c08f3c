"""Online learning: weights adapt at every sample, outlive episodes, and belong to one sub-environment."""

from dataclasses import replace

import gymnasium as gym
import numpy as np
import pytest

import ffgym  # noqa: F401 - registers the environments
from ffgym.agents import LawAgent, static_lugre
from ffgym.agents.bspline import ExtendedBSN, StaticBSN
from ffgym.agents.online_lffc import OnlineLFFC
from ffgym.core.errors import FFGymError

OPTIONS = {"frequencies": [1.0], "preview": 1, "action_scale": 30}


@pytest.fixture
def env():
    return gym.make("ffgym/OneAxis-v0", duration=2.0, **OPTIONS)


def episode(agent, env, state):
    """RMS motor error [rad] of an episode, and the state after it."""
    observation, _ = env.reset(seed=0)
    errors, over, start = [], False, True
    while not over:
        action, state = agent.predict(observation, state, np.array(start))
        observation, _, terminated, truncated, _ = env.step(action)
        over, start = terminated or truncated, False
        errors.append(agent.agent.layout.read(observation, "error")[0])
    return np.sqrt(np.mean(np.square(errors))), state


@pytest.mark.parametrize("kind", [pytest.param(StaticBSN, marks=pytest.mark.slow), ExtendedBSN])
def test_errors_fall_from_episode_to_episode(kind, env, one_axis):
    idle = OnlineLFFC.for_env(kind.zero(1), env, one_axis.servo, rate=1e-12)
    without, _ = episode(idle, env, None)
    agent, state, errors = OnlineLFFC.for_env(kind.zero(1), env, one_axis.servo), None, []
    for _ in range(8):
        error, state = episode(agent, env, state)
        errors.append(error)
    assert errors[0] < without
    assert errors[-1] < errors[0]
    assert errors[-1] < 0.25 * without


def test_one_step_is_3_15_with_u_p_in_place_of_the_error(env, one_axis):
    network = replace(StaticBSN.zero(1), coefficients=np.random.default_rng(0).normal(size=(1, 1, 79)))
    agent = OnlineLFFC.for_env(network, env, one_axis.servo, rate=0.3)
    observation, _ = env.reset(seed=0)
    for _ in range(20):  # so that there are errors
        observation = env.step(np.array([0.1]))[0]
    layout, servo = agent.agent.layout, one_axis.servo
    u_p = servo.position_gain * layout.read(observation, "error")
    u_p += servo.velocity_gain * layout.read(observation, "error_rate")
    now = layout.read(observation, "reference_velocity")
    values, numbers = network.basis.active(now)
    expected = network.coefficients.copy()
    expected[0, 0, numbers[0]] += 0.3 * u_p * values[0]
    action, state = agent.predict(observation)
    np.testing.assert_allclose(state, expected.ravel(), rtol=0, atol=1e-12)
    learned = agent.network_of(state)
    ahead = [layout.read(observation, name, ahead_by=1) for name in ("reference_velocity", "reference_acceleration")]
    torque = action * layout["added_torque"].scale
    np.testing.assert_allclose(torque, learned.torque_at(*ahead), rtol=0, atol=1e-12)


def test_a_batch_is_the_same_as_its_rows_one_by_one(one_axis):
    vector = gym.make_vec("ffgym/OneAxis-v0", num_envs=3, **{**OPTIONS, "frequencies": [1.0, 2.0, 3.0]})
    agent = OnlineLFFC.for_env(ExtendedBSN.zero(1), vector, one_axis.servo)
    observations, _ = vector.reset(seed=1)
    together, alone = None, [None] * 3
    for _ in range(50):
        actions, together = agent.predict(observations, together)
        for i in range(3):
            action, alone[i] = agent.predict(observations[i], alone[i])
            np.testing.assert_array_equal(actions[i], action)
        observations = vector.step(actions)[0]
    np.testing.assert_array_equal(together, np.stack(alone))
    assert len(np.unique(together, axis=0)) > 1


def test_nothing_is_learned_at_standstill(arm):
    env = gym.make("ffgym/CirclePath-v0", positions=["p1"], speeds=[0.1], preview=1, action_scale=8)
    agent = OnlineLFFC.for_env(StaticBSN.zero(6), env, arm.robot.servo)
    observation, _ = env.reset(seed=0)
    observation = env.step(np.full(6, 0.05))[0]
    assert agent.agent.layout.read(observation, "error").any()
    _, state = agent.predict(observation)
    assert not state.any()


def test_the_state_that_is_passed_in_is_not_changed(env, one_axis):
    agent = OnlineLFFC.for_env(StaticBSN.zero(1), env, one_axis.servo)
    observation, _ = env.reset(seed=0)
    _, first = agent.predict(observation)
    observation = env.step(np.array([0.5]))[0]
    before = first.copy()
    _, second = agent.predict(observation, first)
    np.testing.assert_array_equal(first, before)
    assert (second != first).any()


@pytest.mark.parametrize("wrong", [np.zeros(3), np.zeros((2, 79)), np.full(79, np.nan)])
def test_a_state_of_another_shape_or_without_numbers_is_refused(wrong, env, one_axis):
    agent = OnlineLFFC.for_env(StaticBSN.zero(1), env, one_axis.servo)
    observation, _ = env.reset(seed=0)
    with pytest.raises(FFGymError, match="state"):
        agent.predict(observation, wrong)


def test_what_cannot_learn_online_is_refused(env, one_axis, irb4600):
    with pytest.raises(FFGymError, match="lugre_static is no B-spline network"):
        OnlineLFFC(agent=LawAgent.for_env(static_lugre(one_axis), env), servo=one_axis.servo)
    with pytest.raises(FFGymError, match="servo of 6 motors"):
        OnlineLFFC.for_env(StaticBSN.zero(1), env, irb4600.servo)
    with pytest.raises(FFGymError, match="rate"):
        OnlineLFFC.for_env(StaticBSN.zero(1), env, one_axis.servo, rate=0.0)
