"""The table of motions gives each sub-environment the rows of its motion, whatever has come and gone before."""

import numpy as np
import pytest

from ffgym.envs import bank
from ffgym.envs.bank import MotionBank
from ffgym.envs.motion import Columns, Motion
from ffgym.paths import joint_reference, random_multisine
from ffgym.robot import RigidArm


@pytest.fixture(scope="module")
def motions(one_axis):
    """Motions of different lengths."""
    arm, rng = RigidArm(one_axis), np.random.default_rng(0)
    durations = rng.uniform(1.1, 3.0, size=12)
    paths = [random_multisine(rng, np.zeros(1), np.ones(1) * 0.01, duration) for duration in durations]
    return [Motion(reference=joint_reference(one_axis, path), arm=arm, task={}) for path in paths]


@pytest.mark.parametrize("kept_rows", [0, 1500, 200_000])
def test_rows_are_those_of_the_motion_that_is_followed(motions, monkeypatch, kept_rows):
    monkeypatch.setattr(bank, "_KEEP_ROWS", kept_rows)
    n, width, rng = 4, 3, np.random.default_rng(1)
    table = MotionBank(n, Columns(n_joints=1, has_tcp=False), padding=width)
    for i in range(n):
        table.assign(i, motions[i])
    for _ in range(60):
        table.assign(int(rng.integers(n)), motions[int(rng.integers(len(motions)))])
        followed = [motion for motion in table.motions if motion is not None]
        step = np.array([rng.integers(motion.n_steps + 1) for motion in followed])
        window = table.window(step, width)
        for i, motion in enumerate(followed):
            np.testing.assert_array_equal(window[i], motion.rows(width)[step[i] : step[i] + width])


def test_a_motion_that_several_follow_is_stored_once(motions):
    table = MotionBank(3, Columns(n_joints=1, has_tcp=False), padding=2)
    for i in range(3):
        table.assign(i, motions[0])
    assert table._filled == motions[0].n_steps + 1 + 2
    window = table.window(np.zeros(3, dtype=np.int64), 2)
    assert not np.shares_memory(window, table._table)


def test_what_nobody_follows_is_forgotten_when_room_is_needed(motions, monkeypatch):
    monkeypatch.setattr(bank, "_KEEP_ROWS", 0)
    table = MotionBank(1, Columns(n_joints=1, has_tcp=False), padding=2)
    for motion in 5 * motions:
        table.assign(0, motion)
    longest = max(motion.n_steps for motion in motions) + 3
    assert len(table._table) < 2 * 1.25 * longest
