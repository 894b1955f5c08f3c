"""Set-points that are kept are those that would be computed, and keeping them ends when there are too many."""

import gymnasium as gym
import numpy as np
import pytest

from ffgym.envs import bank


def run(monkeypatch, largest, **arguments):
    """Observations of 2 sub-environments over several episodes, and whether set-points were kept to the end."""
    monkeypatch.setattr(bank, "LARGEST", largest)
    env = gym.make_vec("ffgym/CirclePath-v0", num_envs=2, autoreset_mode="SameStep", horizon=90, **arguments)
    seen = [env.reset(seed=0)[0]]
    rng = np.random.default_rng(0)
    seen += [env.step(rng.uniform(-1, 1, size=(2, 6)))[0] for _ in range(300)]
    return np.array(seen), env.unwrapped.core._bank._controls is not None


MIB = 2**20


@pytest.mark.parametrize("largest", [0, 3 * MIB])
def test_kept_and_computed_set_points_give_the_same_bits(monkeypatch, largest):
    """3 MiB hold the first motions of this run only: keeping ends in the middle of it."""
    kept, keeps = run(monkeypatch, 64 * MIB, speeds=[0.1, 0.04], order="one")
    computed, still_keeps = run(monkeypatch, largest, speeds=[0.1, 0.04], order="one")
    assert keeps
    assert not still_keeps
    np.testing.assert_array_equal(kept, computed)


def test_all_motions_of_the_circle_test_are_kept():
    env = gym.make_vec("ffgym/CirclePath-v0", num_envs=12, sampling="sequence")
    env.reset(seed=0)
    assert env.unwrapped.core._bank._controls is not None


def test_they_follow_motions_that_move_in_the_table(monkeypatch):
    """Few rows are kept, so that the table is packed anew again and again."""
    wanted, _ = run(monkeypatch, 0, order="shuffled", speeds=[0.1])
    monkeypatch.setattr("ffgym.envs.bank._KEEP_ROWS", 0)
    packed, keeps = run(monkeypatch, 64 * MIB, order="shuffled", speeds=[0.1])
    assert keeps
    np.testing.assert_array_equal(wanted, packed)
