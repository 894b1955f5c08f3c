"""The lead of the thesis is a half circle of half the radius, and stands beside the smooth one."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from path_samples import magnitudes, vectors

from ffgym.core.errors import FFGymError
from ffgym.paths import circle_test
from ffgym.paths.circles import HalfCircle

CENTRE = np.array([1.3, -0.2, 0.6])


def test_the_half_circle_starts_at_the_centre_and_joins_the_circle_in_its_tangent_only():
    lead = HalfCircle()
    ends = np.array([0.0, lead.length])
    np.testing.assert_allclose(lead.point(ends), [[0, 1], [0, 0]], atol=1e-15)
    np.testing.assert_allclose(lead.heading(ends), [-np.pi, 0], atol=1e-15)
    np.testing.assert_array_equal(lead.bend(ends), 2)


@given(st.floats(1e-3, np.pi / 2 - 1e-3))
def test_its_heading_is_the_direction_of_its_points_and_its_curvature_the_rate_of_its_heading(s):
    lead, h = HalfCircle(), 1e-5
    near = np.array([s - h, s + h])
    step = np.diff(lead.point(near), axis=0)[0] / (2 * h)
    heading = lead.heading(np.array([s]))[0]
    np.testing.assert_allclose(step, [np.cos(heading), np.sin(heading)], atol=1e-9)
    assert np.diff(lead.heading(near))[0] / (2 * h) == pytest.approx(lead.bend(np.array([s]))[0])


@settings(max_examples=15)
@given(
    radius=magnitudes(1e-3, 1.0),
    normal=vectors(-5.0, 5.0).filter(lambda v: np.linalg.norm(v) > 1e-3),
    start_angle=st.floats(-10.0, 10.0),
)
def test_leads_run_on_circles_of_half_the_radius_through_the_centre(radius, normal, start_angle):
    path = circle_test(
        CENTRE, radius, radii=[radius], normal=normal, start_angle=start_angle, lead="half_circle", dt=0.01
    )
    circle = next(phase for phase in path.phases if phase.kind == "circle")
    for phase in path.phases:
        if phase.kind in ("lead_in", "lead_out"):
            rows = (path.t > phase.start) & (path.t < phase.end)
            middle = CENTRE + 0.5 * joint_of(path, circle, radius)
            away = np.linalg.norm(path.position[rows] - middle, axis=1)
            np.testing.assert_allclose(away, 0.5 * radius, rtol=1e-9, atol=1e-12)


def joint_of(path, circle, radius):
    """Where the circle is joined, relative to its centre: its sample turned back along the circle."""
    row = np.searchsorted(path.t, circle.start)
    arm, tangent = path.position[row] - CENTRE, path.velocity[row] / np.linalg.norm(path.velocity[row])
    back = (path.t[row] - circle.start) * np.linalg.norm(path.velocity[row]) / radius
    return np.cos(back) * arm - np.sin(back) * radius * tangent


def test_speed_is_continuous_and_acceleration_jumps_where_the_lead_joins():
    speed, radius = 0.04, 0.003
    path = circle_test(CENTRE, speed, radii=[radius], lead="half_circle", dt=1e-5)
    row = int(np.searchsorted(path.t, next(p for p in path.phases if p.kind == "circle").start))
    before, after = path.acceleration[row - 1], path.acceleration[row]
    assert np.linalg.norm(np.diff(path.velocity, axis=0), axis=1).max() <= 2 * speed**2 / radius * 1.01e-5
    assert np.linalg.norm(after - before) == pytest.approx(speed**2 / radius, rel=1e-2)


def test_a_lead_that_is_unknown_is_refused():
    with pytest.raises(FFGymError, match=r"Unknown lead 'spiral'\. Available: half_circle, smooth"):
        circle_test(CENTRE, 0.01, lead="spiral")
