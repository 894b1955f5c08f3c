"""Lines and arcs by arc length."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from path_differences import check_curve
from path_samples import vectors

from ffgym.core.errors import FFGymError
from ffgym.paths.curves import Arc, Line, Part, Still, arc_about, arc_through

few = settings(max_examples=30)


def apart(*points):
    return min(np.linalg.norm(np.subtract(a, b)) for i, a in enumerate(points) for b in points[:i]) > 0.05


@few
@given(start=vectors(-2, 2), end=vectors(-2, 2))
def test_a_line_runs_from_its_start_to_its_end(start, end):
    assume(apart(start, end))
    line = Line(start=np.array(start), end=np.array(end))
    check_curve(line)
    points = line.at(np.array([0.0, line.length]))[0]
    np.testing.assert_array_equal(points, [start, end])


@few
@given(start=vectors(-1, 1), via=vectors(-1, 1), end=vectors(-1, 1))
def test_an_arc_runs_through_its_three_points_in_order(start, via, end):
    a, b, c = np.array(start), np.array(via), np.array(end)
    sine = np.linalg.norm(np.cross(b - a, c - a)) / (np.linalg.norm(b - a) * np.linalg.norm(c - a) + 1e-12)
    assume(apart(a, b, c) and sine > 0.05)
    arc = arc_through(a, b, c)
    check_curve(arc)
    np.testing.assert_allclose(arc.at(np.array([0.0, arc.length]))[0], [a, c], atol=1e-9)
    points = arc.at(np.linspace(0, arc.length, 20001))[0]
    assert np.linalg.norm(points - b, axis=1).min() < arc.length / 2e4
    np.testing.assert_allclose(np.linalg.norm(points - arc.centre, axis=1), arc.radius, rtol=1e-9)


def test_a_half_circle_goes_the_way_its_point_says():
    for side in (1, -1):
        arc = arc_through(np.array([1.0, 0, 0]), np.array([0.0, side, 0]), np.array([-1.0, 0, 0]))
        np.testing.assert_allclose(arc.at(np.array([0.0]))[1], [[0, side, 0]], atol=1e-12)
        assert arc.angle == pytest.approx(np.pi)


def test_three_quarters_of_a_circle_are_the_long_way_round():
    arc = arc_through(np.array([1.0, 0, 0]), np.array([-1.0, 0, 0]), np.array([0.0, -1, 0]))
    assert arc.angle == pytest.approx(1.5 * np.pi)


@pytest.mark.parametrize(
    "points",
    [
        ((0, 0, 0), (1, 0, 0), (2, 0, 0)),
        ((0, 0, 0), (0, 0, 0), (1, 0, 0)),
        ((0, 0, 0), (1, 1, 0), (0, 0, 0)),
        ((0, 0, 0), (0.01, 0, 0), (0.02, 1e-10, 0)),  # what inverse kinematics leave bends no arc
        ((0, 0, 0), (0.01, 0.01, 0), (0, 0, 1e-10)),
        ((0, 0, 0), (0.01, 0.01, 0), (0.01, 0.01, 5e-8)),
    ],
)
def test_points_on_a_line_or_twice_make_no_arc(points):
    with pytest.raises(FFGymError, match="lie on a line or coincide"):
        arc_through(*(np.array(p, dtype=float) for p in points))


@few
@given(centre=vectors(-1, 1), arm=vectors(-1, 1), guide=vectors(-1, 1), angle=st.floats(0.1, 2 * np.pi))
def test_an_arc_about_an_axis_keeps_its_distance_and_turns_by_the_right_hand(centre, arm, guide, angle):
    normal = np.cross(arm, guide)
    assume(np.linalg.norm(arm) > 0.05 and np.linalg.norm(normal) > 0.01)
    start = np.array(centre) + arm
    arc = arc_about(np.array(centre), start, normal, angle)
    check_curve(arc)
    assert arc.length == pytest.approx(np.linalg.norm(arm) * angle)
    np.testing.assert_allclose(arc.at(np.array([0.0]))[0][0], start, atol=1e-12)
    assert np.cross(arm, arc.at(np.array([0.0]))[1][0]) @ normal > 0


def test_an_arc_starts_in_its_plane_and_beside_its_centre():
    up = np.array([0, 0, 1.0])
    for start in ((1.0, 0, 0.01), (0.0, 0, 0)):
        with pytest.raises(FFGymError, match="must lie in the plane"):
            arc_about(np.zeros(3), np.array(start), up, 1.0)
    with pytest.raises(FFGymError, match="angle of an arc"):
        arc_about(np.zeros(3), np.array([1.0, 0, 0]), up, 0.0)


def test_a_part_of_a_curve_is_the_curve_there():
    arc = Arc(centre=np.zeros(2), first=np.array([1.0, 0]), second=np.array([0, 1.0]), radius=2.0, angle=1.0)
    part = Part(curve=arc, start=0.5, end=1.5)
    assert part.length == 1.0
    for one, other in zip(part.at(np.array([0.0, 1.0])), arc.at(np.array([0.5, 1.5])), strict=True):
        np.testing.assert_array_equal(one, other)


def test_a_point_does_not_move_and_a_line_needs_two():
    still = Still(point=np.array([1.0, 2, 3]), angle=0.5)
    assert still.length == 0.5
    np.testing.assert_array_equal(still.at(np.array([0.2]))[0], [[1, 2, 3]])
    assert not np.any(still.at(np.array([0.2]))[1:])
    with pytest.raises(FFGymError, match="no direction"):
        Line(start=np.ones(3), end=np.ones(3))
