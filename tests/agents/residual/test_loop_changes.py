"""Trainings whose residual acts with more gain or later, so that the loop of the policy bears it."""

import numpy as np
import pytest

from ffgym.agents.residual.environment import LoopChanges, make_environment
from ffgym.agents.residual.training import train
from ffgym.cli.train_policy import options_of
from ffgym.core.errors import FFGymError
from tests.agents.residual.residual_samples import tiny


def begun(gain, delay, count=200, seed=0):
    changes = LoopChanges(gain=gain, delay=delay, n_envs=count, n_joints=3, rng=np.random.default_rng(seed))
    changes.begin(np.ones(count, dtype=np.bool_))
    return changes


def test_factors_and_delays_are_drawn_up_to_the_margins():
    changes = begun(2.0, 2)
    assert 1.0 <= changes.factors.min() < 1.05
    assert 1.9 < changes.factors.max() <= 2.0
    assert set(changes.delays) == {0, 1, 2}
    assert np.median(changes.factors) == pytest.approx(np.sqrt(2), rel=0.05)


def test_residuals_act_later_and_stronger_by_what_was_drawn():
    changes = begun(2.0, 1)
    first, second = np.full((200, 3), 0.25), np.full((200, 3), -0.5)
    acting = changes.apply(first)
    np.testing.assert_array_equal(acting[changes.delays == 1], 0.0)
    np.testing.assert_allclose(acting[changes.delays == 0][:, 0], 0.25 * changes.factors[changes.delays == 0])
    acting = changes.apply(second)
    np.testing.assert_allclose(acting[changes.delays == 1][:, 0], 0.25 * changes.factors[changes.delays == 1])
    np.testing.assert_allclose(acting[changes.delays == 0][:, 0], -0.5 * changes.factors[changes.delays == 0])


def test_an_episode_that_begins_has_its_own_changes_and_no_past():
    changes = begun(2.0, 1)
    changes.apply(np.ones((200, 3)))
    factors, delays = changes.factors.copy(), changes.delays.copy()
    where = np.arange(200) < 100
    changes.begin(where)
    np.testing.assert_array_equal(changes.factors[~where], factors[~where])
    np.testing.assert_array_equal(changes.delays[~where], delays[~where])
    assert np.mean(changes.factors[where] == factors[where]) < 0.01
    assert changes.delays[where].tolist() != delays[where].tolist()
    acting = changes.apply(np.zeros((200, 3)))
    np.testing.assert_array_equal(acting[where], 0.0)
    assert np.all(acting[~where & (delays == 1)] > 0.0)


@pytest.mark.parametrize("changed", [{"gain_margin": 3.0}, {"delay_margin": 9}])
def test_the_policy_sees_its_own_residual_and_the_motors_what_acts(changed):
    plain, margins = (make_environment(tiny(randomization=False, **own)) for own in ({}, changed))
    actions = np.full((2, 6), 0.2, dtype=np.float32)
    errors = []
    for env in (plain, margins):
        env.seed(5)
        env.reset()
        env.step(actions)
        seen = env.step(actions)[0].reshape(2, 6, -1)
        np.testing.assert_allclose(seen[..., 2], 0.2, rtol=1e-6)
        errors.append(seen[..., 0])
        env.close()
    assert not np.isclose(*errors).any()


def test_changes_are_drawn_anew_where_an_episode_ends():
    env = make_environment(tiny(gain_margin=3.0), speeds=[0.1], radii=[0.001])
    env.seed(0)
    env.reset()
    actions, seen = np.zeros((2, 6), dtype=np.float32), []
    for _ in range(400):
        before = env._changes.factors
        if (done := env.step(actions)[2]).any():
            seen.append(env._changes.factors == before)
            np.testing.assert_array_equal(seen[-1], ~done)
    env.close()
    assert seen


def test_a_training_with_margins_can_be_asked_for_and_ends_alike_if_it_was_stopped(tmp_path):
    training = tiny(gain_margin=2.0, delay_margin=1)
    words = options_of(training)
    assert words[words.index("--gain-margin") + 1] == "2.0"
    assert words[words.index("--delay-margin") + 1] == "1"
    train(training, tmp_path / "whole")

    def stop(done, total):
        if done > 20:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        train(training, tmp_path / "parts", watch=stop)
    train(training, tmp_path / "parts")
    whole, parts = ((tmp_path / name / "policy.npz").read_bytes() for name in ("whole", "parts"))
    assert whole == parts


@pytest.mark.parametrize("own", [{"gain_margin": 0.5}, {"delay_margin": -1}])
def test_margins_that_are_none_are_refused(own):
    with pytest.raises(FFGymError, match=next(iter(own))):
        tiny(**own)
