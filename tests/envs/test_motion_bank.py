"""One table for all motions: rows are never mixed up, and what nobody follows is forgotten in the end."""

import gymnasium as gym
import numpy as np
import pytest

from ffgym.envs import bank as bank_module
from ffgym.envs.bank import MotionBank
from ffgym.envs.joint_motion import RandomTasks
from tests.envs.env_samples import JOINTS

PADDING = 3


@pytest.fixture(scope="module")
def motions(one_axis):
    """Random motions of different lengths."""
    rng = np.random.default_rng(0)
    made = []
    for k in range(40):
        tasks = RandomTasks(one_axis, duration=1.0 + 0.05 * (k % 7), peak_speeds=(1.0, 5.0), spread=1.0)
        made.append(tasks.draw(rng, {}))
    return made


@pytest.mark.parametrize("keep", [0, 2000, 200_000])
def test_every_sub_environment_reads_the_rows_of_its_own_motion(motions, monkeypatch, keep):
    monkeypatch.setattr(bank_module, "_KEEP_ROWS", keep)
    bank, rng = MotionBank(4, motions[0].columns, PADDING), np.random.default_rng(1)
    rows = {id(motion): motion.rows(PADDING) for motion in motions}
    followed = [motions[0]] * 4
    for i in range(4):
        bank.assign(i, motions[0])
    longest = max(len(r) for r in rows.values())
    for _ in range(400):
        i, motion = int(rng.integers(4)), motions[rng.integers(len(motions))]
        bank.assign(i, motion)
        followed[i] = motion
        step = np.array([rng.integers(m.n_steps + 1) for m in followed])
        window = bank.rows(bank.places(step, PADDING))
        for k, m in enumerate(followed):
            np.testing.assert_array_equal(window[:, k], rows[id(m)][step[k] : step[k] + PADDING])
        assert len(bank._table) <= 1.25 * (keep + 6 * longest)
        assert len(bank._place) * 250 <= len(bank._table)
    assert bank.motions == followed


def test_a_motion_is_stored_once_however_many_follow_it(motions):
    bank = MotionBank(50, motions[0].columns, PADDING)
    for i in range(50):
        bank.assign(i, motions[i % 2])
    assert len(bank._place) == 2
    assert len(bank._table) < 3 * len(motions[1].rows(PADDING))


def test_what_nobody_follows_is_forgotten_when_room_is_needed(motions, monkeypatch):
    monkeypatch.setattr(bank_module, "_KEEP_ROWS", 0)
    bank = MotionBank(1, motions[0].columns, PADDING)
    for motion in 5 * motions:
        bank.assign(0, motion)
    longest = max(len(motion.rows(PADDING)) for motion in motions)
    assert len(bank._table) < 2 * 1.25 * longest


def test_the_last_sample_is_held_beyond_the_end(motions):
    motion = motions[0]
    bank = MotionBank(1, motion.columns, PADDING)
    bank.assign(0, motion)
    window = bank.rows(bank.places(np.array([motion.n_steps]), PADDING + 1))[:, 0]
    np.testing.assert_array_equal(window, np.tile(window[0], (PADDING + 1, 1)))


def test_a_window_is_a_copy(motions):
    bank = MotionBank(1, motions[0].columns, PADDING)
    bank.assign(0, motions[0])
    before = bank.rows(bank.places(np.array([5]), 2))
    assert not np.shares_memory(before, bank._table)
    bank.rows(bank.places(np.array([5]), 2))[:] = np.nan
    np.testing.assert_array_equal(bank.rows(bank.places(np.array([5]), 2)), before)


def test_hundreds_of_random_episodes_need_no_more_memory_than_a_few(monkeypatch):
    monkeypatch.setattr(bank_module, "_KEEP_ROWS", 2000)
    env = gym.make_vec(JOINTS, num_envs=2, robot="one_axis", duration=1.0, horizon=1, autoreset_mode="SameStep")
    observation, _ = env.reset(seed=0)
    bank = env.core._bank
    for _ in range(200):
        for i, motion in enumerate(env.core.motions):
            seen = env.observation_layout.read(observation, "reference_position")[i]
            np.testing.assert_allclose(seen, motion.reference.q[0], atol=1e-12)
        observation, *_ = env.step(np.zeros((2, 1)))
    assert len(bank._table) < 5000
    assert len(bank._place) < 12
