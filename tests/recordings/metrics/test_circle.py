"""A circle is found again from its points, wherever it lies; what is none is refused."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from ffgym.core.errors import FFGymError
from ffgym.recordings.metrics import fit_circle

few = settings(max_examples=60)
seeds = st.integers(0, 2**32 - 1)


def points_on(rng, radius, centre, turn, count, arc):
    angle = np.sort(rng.uniform(0, arc, count))
    flat = radius * np.stack([np.cos(angle), np.sin(angle), np.zeros(count)], axis=1)
    return centre + turn.apply(flat)


@few
@given(seed=seeds, log_radius=st.floats(-4.0, 1.0), count=st.integers(5, 400))
def test_a_circle_in_space_is_recovered(seed, log_radius, count):
    rng, radius = np.random.default_rng(seed), 10**log_radius
    centre, turn = rng.uniform(-3, 3, 3), Rotation.random(random_state=seed)
    arc = rng.uniform(np.pi, 2 * np.pi)
    points = points_on(rng, radius, centre, turn, count, arc)
    points[[0, -1]] = centre + turn.apply([[radius, 0, 0], [radius * np.cos(arc), radius * np.sin(arc), 0]])
    found = fit_circle(points)
    rounding = 1e-15 / radius**2 + 1e-9
    assert found.radius == pytest.approx(radius, rel=rounding)
    np.testing.assert_allclose(found.centre, centre, atol=radius * rounding)
    assert abs(found.normal @ turn.apply([0, 0, 1])) == pytest.approx(1, abs=1e-6)


@few
@given(seed=seeds)
def test_a_circle_with_a_little_noise_is_still_one(seed):
    rng = np.random.default_rng(seed)
    points = points_on(rng, 0.005, np.ones(3), Rotation.random(random_state=seed), 200, 2 * np.pi)
    found = fit_circle(points + rng.uniform(-1e-6, 1e-6, points.shape))
    assert found.radius == pytest.approx(0.005, abs=1e-6)
    np.testing.assert_allclose(found.centre, 1, atol=1e-6)


@few
@given(seed=seeds)
def test_noise_is_no_circle(seed):
    points = np.random.default_rng(seed).normal(size=(50, 3))
    with pytest.raises(FFGymError, match="no circle: it deviates by"):
        fit_circle(points)


@few
@given(seed=seeds, count=st.integers(4, 200))
def test_a_line_is_no_circle(seed, count):
    rng = np.random.default_rng(seed)
    along = np.linspace(0, 1, count)[:, None] * rng.normal(size=3)
    with pytest.raises(FFGymError, match="no circle"):
        fit_circle(rng.normal(size=3) + along)


@few
@given(seed=seeds)
def test_an_ellipse_is_no_circle(seed):
    angle = np.linspace(0, 2 * np.pi, 100)
    flat = np.stack([np.cos(angle), 0.9 * np.sin(angle), 0 * angle], axis=1)
    with pytest.raises(FFGymError, match="no circle"):
        fit_circle(Rotation.random(random_state=seed).apply(flat))


def test_a_point_is_no_circle():
    with pytest.raises(FFGymError, match="no circle"):
        fit_circle(np.ones((10, 3)))


@pytest.mark.parametrize("points", [np.zeros((3, 3)), np.zeros((5, 2)), np.full((5, 3), np.nan), "round"])
def test_too_few_or_malformed_points_are_refused(points):
    with pytest.raises(FFGymError, match=r"at least 4 points, got 3|circle points"):
        fit_circle(points)
