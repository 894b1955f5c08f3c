"""The spring between motor and arm, solved along samples: against solutions that are known."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.polynomial import Polynomial

from ffgym.agents.flexible_joints import lead_between

DT = 0.004


def samples_of(curve, reach):
    return curve(np.arange(-reach, reach + 1) * DT)[:, None]


@given(coefficients=arrays(float, 5, elements=st.floats(-1, 1)), relaxation=st.floats(0, DT))
def test_the_lead_is_exact_where_it_is_a_polynomial(coefficients, relaxation):
    lead = Polynomial(coefficients / DT ** np.arange(5) * 1e-3)  # every term counts within the samples
    bend = lead + relaxation * lead.deriv()
    found = lead_between(samples_of(bend, 2), np.array([relaxation]), DT)
    for value, order in ((found.angle, 0), (found.speed, 1), (found.acceleration, 2)):
        np.testing.assert_allclose(value * DT**order, lead.deriv(order)(0.0) * DT**order, atol=1e-14)


@pytest.mark.parametrize("reach", [1, 2, 3])
def test_each_derivative_of_a_swinging_lead_is_found_with_its_order(reach):
    omega, at = 100.0, 0.003  # as on r = 1 mm at 100 mm/s

    def errors(dt):
        t, relaxation = at + np.arange(-reach, reach + 1) * dt, 0.2 * dt
        bend = np.sin(omega * t) + relaxation * omega * np.cos(omega * t)
        found = lead_between(bend[:, None], np.array([relaxation]), dt)
        angle, speed = np.sin(omega * at), omega * np.cos(omega * at)
        truth = angle, speed, -(omega**2) * angle
        values = (found.angle, found.speed, found.acceleration)
        return np.abs([value[0] - true for value, true in zip(values, truth, strict=True)])

    observed = np.log2(errors(DT / 4) / errors(DT / 8))
    np.testing.assert_allclose(observed, 2 * reach + 1 - np.arange(3), atol=0.4)


def test_a_rigid_joint_has_no_lead():
    lead = lead_between(np.ones((5, 1)) / np.inf, np.array([0.0]), DT)
    assert not np.any([lead.angle, lead.speed, lead.acceleration])


def test_a_constant_bend_is_the_lead():
    lead = lead_between(np.full((5, 1), 0.001), np.array([8e-4]), DT)
    np.testing.assert_allclose([lead.angle, lead.speed, lead.acceleration], [[0.001], [0], [0]], atol=1e-13)


def test_every_row_has_the_bits_that_it_has_alone():
    bend = np.random.default_rng(0).normal(size=(7, 5, 6))
    relaxation = np.full(6, 8e-4)
    together = lead_between(bend, relaxation, DT)
    for row in range(7):
        np.testing.assert_array_equal(lead_between(bend[row], relaxation, DT).acceleration, together.acceleration[row])
