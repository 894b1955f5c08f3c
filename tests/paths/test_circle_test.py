"""The circle test is a smooth motion whose speed is exact on the circles, whatever its size, place and plane."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from path_samples import STEP, motion, motions
from scipy.interpolate import CubicHermiteSpline

from ffgym.paths import RADII, SPEEDS, circle_test
from ffgym.paths.circles import plane_of

LARGEST_JERK = 3.04
"""Largest jerk in units of speed^3 / radius^2: reached on the lead, the same at every size."""

few = settings(max_examples=15)


def central(values, dt):
    return (values[2:] - values[:-2]) / (2 * dt)


@few
@given(motions())
def test_velocity_and_acceleration_are_derivatives_of_position(m):
    path, v, a = m.path, m.speed, m.speed**2 / min(m.radii)
    np.testing.assert_allclose(central(path.position, m.dt), path.velocity[1:-1], rtol=0, atol=1e-5 * v)
    np.testing.assert_allclose(central(path.velocity, m.dt), path.acceleration[1:-1], rtol=0, atol=2 * STEP * a)


@few
@given(motions())
def test_position_velocity_and_acceleration_are_continuous_and_jerk_scales_with_speed_cubed_over_radius_squared(m):
    v, r = m.speed, min(m.radii)
    jumps = [np.linalg.norm(np.diff(x, axis=0), axis=1).max() for x in (m.path.position, m.path.velocity)]
    assert jumps[0] <= v * m.dt * (1 + 1e-9) + 1e-14
    assert jumps[1] <= 2.5 * v**2 / r * m.dt
    jerk = np.linalg.norm(np.diff(m.path.acceleration, axis=0), axis=1) / m.dt
    assert jerk.max() <= LARGEST_JERK * v**3 / r**2


@pytest.mark.parametrize("speed", SPEEDS)
@pytest.mark.parametrize("radius", RADII)
def test_the_bound_on_jerk_is_tight(speed, radius):
    m = motion(speed=speed, radii=(radius,))
    jerk = np.linalg.norm(np.diff(m.path.acceleration, axis=0), axis=1) / m.dt
    assert jerk.max() > 0.99 * LARGEST_JERK * speed**3 / radius**2


@few
@given(motions())
def test_on_a_circle_speed_and_radius_are_exact_and_the_points_lie_in_the_plane(m):
    for phase, radius in m.circles():
        rows = m.inside(phase)
        arms = m.path.position[rows] - m.centre
        np.testing.assert_allclose(np.linalg.norm(arms, axis=1), radius, rtol=0, atol=1e-12)
        np.testing.assert_allclose(np.linalg.norm(m.path.velocity[rows], axis=1), m.speed, rtol=1e-12)
        np.testing.assert_allclose(m.path.acceleration[rows] @ m.normal, 0, atol=1e-12 * m.speed**2 / radius)
        assert phase.end - phase.start == pytest.approx(2 * np.pi * radius / m.speed, rel=1e-9)


@few
@given(motions())
def test_the_whole_motion_stays_in_the_plane_within_its_largest_circle(m):
    arms = m.path.position - m.centre
    np.testing.assert_allclose(arms @ m.normal, 0, atol=1e-12)
    assert np.linalg.norm(arms, axis=1).max() <= max(m.radii) * 1.06 + 1e-12


@few
@given(motions())
def test_it_starts_and_ends_at_rest_in_the_centre(m):
    for row in (0, -1):
        np.testing.assert_array_equal(m.path.position[row], m.centre)
        np.testing.assert_array_equal(m.path.velocity[row], 0)
        np.testing.assert_array_equal(m.path.acceleration[row], 0)


@few
@given(motions())
def test_circles_turn_about_the_normal_and_start_at_the_start_angle(m):
    plane = plane_of(m.normal)
    for phase, radius in m.circles():
        rows = m.inside(phase)
        arms, t = m.path.position[rows] - m.centre, m.path.t[rows]
        spin = np.cross(arms, m.path.velocity[rows]) @ m.normal
        np.testing.assert_allclose(spin, radius * m.speed, rtol=1e-9)
        angle = m.start_angle + m.speed / radius * (t[0] - phase.start)
        first = radius * (np.cos(angle) * plane.first + np.sin(angle) * plane.second)
        np.testing.assert_allclose(arms[0], first, atol=1e-9 * radius + 1e-13)


@few
@given(motions(n_radii=1))
def test_the_lead_out_is_the_lead_in_backwards_mirrored_about_the_radius_through_the_joint(m):
    lead_in, lead_out = (next(p for p in m.path.phases if p.kind == kind) for kind in ("lead_in", "lead_out"))
    tau = np.linspace(0, lead_in.end - lead_in.start, 50)
    curve = CubicHermiteSpline(m.path.t, m.path.position - m.centre, m.path.velocity)
    plane = plane_of(m.normal)
    joint = np.cos(m.start_angle) * plane.first + np.sin(m.start_angle) * plane.second
    going_in, coming_out = curve(lead_in.end - tau), curve(lead_out.start + tau)
    mirrored = 2 * (going_in @ joint)[:, None] * joint - going_in
    np.testing.assert_allclose(coming_out, mirrored, atol=1e-9 * m.radii[0] + 1e-13)


@few
@given(motions())
def test_phases_follow_each_other_without_gaps_and_are_named(m):
    phases = m.path.phases
    kinds = ["standstill"] + ["lead_in", "circle", "lead_out", "standstill"] * len(m.radii)
    assert [phase.kind for phase in phases] == kinds
    assert phases[0].start == 0
    assert all(a.end == b.start for a, b in pairwise(phases))
    assert [p.label for p in phases[:3]] == [
        "rest 0",
        f"lead-in {m.radii[0] * 1e3:g} mm",
        f"circle {m.radii[0] * 1e3:g} mm",
    ]
    assert phases[-1].label == f"rest {len(m.radii)}"
    for i in range(0, len(phases), 4):
        assert phases[i].end - phases[i].start == pytest.approx(m.dwell, rel=1e-6)
        np.testing.assert_array_equal(m.path.velocity[m.inside(phases[i])], 0)
    assert 0 <= m.path.t[-1] - phases[-1].end < m.dt


@few
@given(motions(n_radii=1))
def test_a_circle_scales_with_its_radius(m):
    """Twice the radius at twice the speed is the same motion, twice as large."""
    twice = motion(
        centre=2 * m.centre, radii=(2 * m.radii[0],), speed=2 * m.speed, normal=m.normal, start_angle=m.start_angle
    )
    np.testing.assert_allclose(twice.path.position, 2 * m.path.position, rtol=0, atol=1e-13)


def test_the_motion_of_the_thesis_has_three_circles_at_4_ms():
    path = circle_test((1.3, -0.2, 0.6), 0.01)
    assert [p.label for p in path.phases if p.kind == "circle"] == ["circle 1 mm", "circle 3 mm", "circle 5 mm"]
    np.testing.assert_allclose(np.diff(path.t), 0.004, rtol=1e-9)
