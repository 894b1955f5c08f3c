"""Friction averaged around samples: momentum, steady state, and a step like the whole."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ffgym.agents.flexible_joints import friction_along, step_friction
from ffgym.control import DynamicLuGreExact

DT = 0.004


@pytest.fixture(scope="module")
def law(one_axis):
    return DynamicLuGreExact(one_axis.friction)


def reversal(late):
    """Motor speed [rad/s] that turns round within 8 ms, `late` [s] after a sample, and is constant before and after."""
    return np.clip(1000.0 * (np.arange(60) * DT - 0.16 - late), -4.0, 4.0)[:, None]


def fine_friction(law, speed, n=200):
    """Friction [N m] at the middle of `n` parts of each step, (T - 1, n)."""
    shares = (np.arange(n) + 0.5) / n
    fine = speed[:-1] + (speed[1:] - speed[:-1]) * shares
    keep, gain = law.friction.exact_bristle_factors(fine, DT / n)
    z, middles = 0.0, np.empty_like(fine)
    for k, i in np.ndindex(fine.shape):
        next_z = keep[k, i] * z + gain[k, i]
        middles[k, i], z = 0.5 * (z + next_z), next_z
    return law.friction.torque(middles, fine)


def test_straight_lines_between_averages_give_the_momentum_that_friction_takes(law):
    misses = []
    for late in (0.0, 0.001, 0.002, 0.003):
        speed = reversal(late)
        last = np.full((1, 1), law.friction.steady_torque(speed[-1])[0])
        averaged = np.concatenate([friction_along(law, speed, DT), last])
        taken = fine_friction(law, speed)[20:].mean(axis=1).sum() * DT  # by then the bristles have bent
        misses.append([abs(np.trapezoid(torque[20:, 0], dx=DT) - taken) for torque in (averaged, law.along(speed, DT))])
    worst_averaged, worst_sampled = np.max(misses, axis=0)
    assert worst_averaged < 0.01 * worst_sampled


@given(v=st.floats(0.5, 20), sign=st.sampled_from([-1, 1]))
def test_steady_friction_is_shared_equally_by_both_ends(law, v, sign):
    dq = np.array([sign * v])
    z = law.friction.stribeck_level(dq) / law.friction.bristle_stiffness * sign
    start, end, next_z = step_friction(law, z, dq, dq, DT)
    np.testing.assert_allclose(start, 0.5 * law.friction.steady_torque(dq), rtol=1e-9)
    np.testing.assert_allclose(end, start, rtol=1e-9)
    np.testing.assert_allclose(next_z, z, rtol=1e-9)


def test_the_parts_of_a_step_add_up_to_its_mean_friction(law):
    speed = reversal(0.001)[:40]
    fine, z = fine_friction(law, speed), np.zeros(1)
    for k in range(len(speed) - 1):
        start, end, z = step_friction(law, z, speed[k], speed[k + 1], DT)
        np.testing.assert_allclose(start + end, fine[k].mean(), atol=1e-3 * law.friction.static[0])


def test_steps_one_by_one_give_the_whole(law):
    speed, z, before, torques = reversal(0.001), np.zeros(1), np.zeros(1), []
    for k in range(len(speed) - 1):
        start, end, z = step_friction(law, z, speed[k], speed[k + 1], DT)
        torques.append(before + start)
        before = end
    np.testing.assert_allclose(friction_along(law, speed, DT), torques, atol=1e-12)
