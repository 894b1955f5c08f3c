"""Banded systems give what the recursions that they stand for give, step by step."""

import numpy as np
import pytest

from ffgym.diagnosis.replay.recursions import first_order, swing

RNG = np.random.default_rng(7)


@pytest.mark.parametrize("samples", [1, 2, 700])
def test_a_recursion_of_first_order_is_that_of_a_loop(samples):
    keep, gain = RNG.uniform(0, 1, (2, samples - 1, 3, 2))
    start = RNG.normal(size=(3, 2))
    expected = [start]
    for k in range(samples - 1):
        expected.append(keep[k] * expected[-1] + gain[k])
    np.testing.assert_allclose(first_order(keep, gain, start), expected, rtol=1e-13)


@pytest.mark.parametrize(("samples", "joints", "loads"), [(2, 2, 1), (300, 3, 2), (900, 1, 1), (257, 6, 3)])
def test_a_swing_is_that_of_newmarks_method_step_by_step(samples, joints, loads):
    dt, eye = 0.002, np.eye(joints)
    mass = 5 * eye + RNG.uniform(-0.5, 0.5, (samples, joints, joints))
    damping = 30 * eye + RNG.uniform(-1, 1, (samples, joints, joints))
    stiffness = 2e4 * eye + RNG.uniform(-1e3, 1e3, (samples, joints, joints))
    load = RNG.normal(size=(samples, joints, loads))
    inverse = np.linalg.inv(mass + dt / 2 * damping + dt**2 / 4 * stiffness)
    start = np.linalg.solve(stiffness[0], load[0])

    x, v, a = start, np.zeros_like(start), np.zeros_like(start)
    expected = [(x, v, a)]
    for k in range(1, samples):
        x, v = x + dt * v + dt**2 / 4 * a, v + dt / 2 * a
        a = inverse[k] @ (load[k] - damping[k] @ v - stiffness[k] @ x)
        x, v = x + dt**2 / 4 * a, v + dt / 2 * a
        expected.append((x, v, a))

    found = swing(inverse, inverse @ stiffness, inverse @ damping, load, start, dt)
    for own, true in zip(found, np.swapaxes(expected, 0, 1), strict=True):
        np.testing.assert_allclose(own, true, rtol=0, atol=1e-12 * np.abs(true).max())
