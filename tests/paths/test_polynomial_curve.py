"""Corner blends and splines: smooth, through their points, measured by arc length."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from path_differences import check_curve, unit
from path_samples import vectors

from ffgym.core.errors import FFGymError
from ffgym.paths.curves import Line, Part, arc_through, blend, spline_through

few = settings(max_examples=25)
points = st.lists(vectors(-1, 1), min_size=2, max_size=7)


def legs(first, second, radius):
    """Two lines that meet at the origin, cut off at a distance from it."""
    before = Line(start=-unit(first), end=-radius * unit(first))
    after = Line(start=radius * unit(second), end=unit(second))
    return before, after


def joints(before, middle, after):
    """Values and derivatives on both sides of both joints."""
    for one, other in ((before, middle), (middle, after)):
        yield from zip(one.at(np.array([one.length])), other.at(np.zeros(1)), range(4), strict=True)


@few
@given(first=vectors(-1, 1), second=vectors(-1, 1), radius=st.floats(1e-4, 0.5))
def test_a_blend_meets_its_legs_in_tangent_and_curvature_and_stays_in_its_zone(first, second, radius):
    assume(min(np.linalg.norm(first), np.linalg.norm(second)) > 0.1)
    assume(unit(first) @ unit(second) > -0.95)
    before, after = legs(first, second, radius)
    curve = blend(before, after)
    check_curve(curve, rtol=0.02)
    for one, other, order in joints(before, curve, after):
        if order < 3:
            np.testing.assert_allclose(one, other, atol=1e-7 / radius**order * radius)
    inside = curve.at(np.linspace(0, curve.length, 500))[0]
    assert np.linalg.norm(inside, axis=1).max() <= radius * (1 + 1e-9)


@few
@given(via=vectors(-1, 1), direction=vectors(-1, 1), radius=st.floats(0.01, 0.2))
def test_a_blend_meets_an_arc_in_its_curvature(via, direction, radius):
    start, corner = np.array([-2.0, 0, 0]), np.zeros(3)
    assume(np.linalg.norm(np.cross(via, start)) > 0.2 and np.linalg.norm(direction) > 0.2)
    arc = arc_through(start, np.array(via) - [1.0, 0, 0], corner) if abs(via[1]) + abs(via[2]) > 0.2 else None
    assume(arc is not None and arc.length > 1.0)
    tangent = arc.at(np.array([arc.length]))[1][0]
    assume(tangent @ unit(direction) > -0.9)
    before = Part(curve=arc, start=0.0, end=arc.length - radius)
    after = Line(start=radius * unit(direction), end=unit(direction))
    curve = blend(before, after)
    for one, other, order in joints(before, curve, after):
        if order < 3:
            np.testing.assert_allclose(one, other, atol=1e-6 / radius**order)


def test_a_right_angled_blend_bends_hardly_more_than_the_best_quintic():
    before, after = legs((1, 0, 0), (0, 1, 0), 0.5)
    curve = blend(before, after)
    sharpest = np.linalg.norm(curve.at(np.linspace(0, curve.length, 2000))[2], axis=1).max()
    assert sharpest * 0.5 < 1.04 * 1.1709  # found by trying all speeds at its ends


@few
@given(through=points)
def test_a_spline_passes_its_points_at_its_knots_and_is_smooth(through):
    through = np.array(through)
    assume(np.linalg.norm(np.diff(through, axis=0), axis=1).min() > 0.1)
    try:
        curve = spline_through(through)
    except FFGymError:  # it turns back on the spot
        assume(False)
    np.testing.assert_allclose(curve.at(curve.knots)[0], through, atol=1e-9)
    s = np.linspace(0, curve.length, 3001)
    position, tangent, bend, _ = curve.at(s)
    np.testing.assert_allclose(np.linalg.norm(np.diff(position, axis=0), axis=1).sum(), curve.length, rtol=1e-3)
    np.testing.assert_allclose(np.linalg.norm(tangent, axis=1), 1.0, atol=1e-9)
    if np.linalg.norm(bend, axis=1).max() < 30:  # no cusp between near points
        check_curve(curve, kinks=curve.knots, rtol=0.1)


def test_a_closed_spline_is_smooth_where_it_closes():
    corner = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0.3], [0, 1, 0], [0, 0, 0]])
    curve = spline_through(corner, closed=True)
    ends = curve.at(np.array([0.0, curve.length]))
    for part in ends[:3]:
        np.testing.assert_allclose(part[0], part[1], atol=1e-7)


@pytest.mark.parametrize(
    ("through", "closed", "message"),
    [
        ([[0, 0, 0]], False, "two or more points"),
        ([[0, 0, 0], [1, 0, 0], [1, 0, 0]], False, "see point 3"),
        ([[0, 0, 0], [1, 0, 0], [0, 0, 0]], False, "turns back on the spot near point 2"),
        ([[0, 0, 0], [1, 0, 0], [0, 0, 0]], True, "at least 4 points"),
        ([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], True, "end at its first point"),
    ],
)
def test_points_that_make_no_spline_are_refused(through, closed, message):
    with pytest.raises(FFGymError, match=message):
        spline_through(np.array(through, dtype=float), closed=closed)


def test_a_point_of_a_curve_does_not_depend_on_the_others():
    curve = spline_through(np.array([[0.0, 0, 0], [1, 0, 0.2], [1.1, 0.9, 0], [0, 1, 0]]))
    s = np.linspace(0, curve.length, 50)
    together, alone = curve.at(s), [curve.at(s[i : i + 1]) for i in range(50)]
    for order, part in enumerate(together):
        np.testing.assert_array_equal(part, np.concatenate([one[order] for one in alone]))
