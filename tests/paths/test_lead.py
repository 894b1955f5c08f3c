"""The lead from the centre onto a circle, and the speed ramp that runs along it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from path_samples import magnitudes
from scipy.integrate import quad
from scipy.optimize import fsolve

from ffgym.paths.circles import BLEND, UNIT_LEAD, SmoothLead, smooth_ramp

arcs = st.floats(0.0, UNIT_LEAD.length)


def at(function, s):
    return function(np.array([s]))[0]


def test_the_lead_starts_at_the_centre_and_joins_the_circle_in_its_tangent_and_curvature():
    lead = UNIT_LEAD
    np.testing.assert_allclose(at(lead.point, 0.0), [0, 1], atol=1e-13)
    np.testing.assert_allclose(at(lead.point, lead.length), [0, 0], atol=1e-15)
    assert at(lead.heading, lead.length) == pytest.approx(0, abs=1e-15)
    assert at(lead.bend, lead.length) == pytest.approx(1)


def test_its_numbers_solve_the_two_conditions_on_the_centre():
    def miss(unknown):
        return SmoothLead(curvature=unknown[0], length=unknown[1]).point(np.zeros(1))[0] - [0.0, 1.0]

    lead = UNIT_LEAD
    assert fsolve(miss, [2.0, np.pi / 2], xtol=1e-14) == pytest.approx([lead.curvature, lead.length], rel=1e-14)


def test_its_first_part_is_a_circle_and_the_rest_a_clothoid():
    lead = UNIT_LEAD
    s = np.linspace(0, lead.length, 1001)
    early = s <= lead.knot
    assert lead.knot == pytest.approx((1 - BLEND) * lead.length)
    np.testing.assert_array_equal(lead.bend(s[early]), lead.curvature)
    slope = np.diff(lead.bend(s[~early])) / np.diff(s[~early])
    np.testing.assert_allclose(slope, (1 - lead.curvature) / (lead.length - lead.knot), rtol=1e-9)
    assert 1 < lead.curvature < 3


@given(arcs)
def test_its_curvature_is_the_rate_of_its_heading_and_its_heading_the_direction_of_its_points(s):
    lead, h = UNIT_LEAD, 1e-5
    s = float(np.clip(s, h, lead.length - h))
    assert (at(lead.heading, s + h) - at(lead.heading, s - h)) / (2 * h) == pytest.approx(at(lead.bend, s), abs=1e-4)
    step = (at(lead.point, s + h) - at(lead.point, s - h)) / (2 * h)
    angle = at(lead.heading, s)
    np.testing.assert_allclose(step, [np.cos(angle), np.sin(angle)], atol=1e-8)


@given(arcs, arcs)
def test_its_points_are_the_integral_of_its_heading(start, end):
    lead = UNIT_LEAD
    for k, part in enumerate((np.cos, np.sin)):
        moved, _ = quad(lambda s: part(at(lead.heading, s)), start, end, points=[lead.knot], epsabs=1e-12)  # noqa: B023
        assert at(lead.point, end)[k] - at(lead.point, start)[k] == pytest.approx(moved, abs=1e-11)


@given(duration=magnitudes(1e-3, 1e3), speed=magnitudes(1e-3, 1e3))
def test_the_ramp_reaches_its_speed_in_half_the_distance_with_no_acceleration_at_its_ends(duration, speed):
    tau = np.linspace(0, duration, 1001)
    travelled, rate, change = smooth_ramp(tau, duration, speed)
    assert travelled[0] == rate[0] == change[0] == 0
    assert travelled[-1] == pytest.approx(speed * duration / 2)
    assert rate[-1] == pytest.approx(speed)
    assert change[-1] == pytest.approx(0, abs=1e-12 * speed / duration)
    assert np.all(np.diff(rate) >= 0)
    dt = tau[1]
    np.testing.assert_allclose(np.gradient(travelled, dt)[1:-1], rate[1:-1], rtol=0, atol=2e-6 * speed)
    np.testing.assert_allclose(np.gradient(rate, dt)[1:-1], change[1:-1], rtol=0, atol=1e-5 * speed / duration)
    assert np.abs(np.diff(change)).max() <= 6 * speed / duration**2 * dt
