"""Routes: legs joined without kinks, corners within their zones."""

import itertools

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from path_differences import central
from path_samples import vectors
from scipy.spatial.transform import Rotation

from ffgym.core.errors import FFGymError
from ffgym.paths.curves import Line, Part, arc_about
from ffgym.paths.moves import Speed
from ffgym.paths.route import EvenTurn, Leg, SplineTurn, corner_angle, even_turn, meets, round_corners

few = settings(max_examples=25)
SPEED = Speed(tcp=0.1)


def lines(points, turns=None):
    points = [np.array(p, dtype=float) for p in points]
    legs = []
    for i, (a, b) in enumerate(itertools.pairwise(points)):
        length = float(np.linalg.norm(b - a))
        turning = None if turns is None else even_turn(turns[i], turns[i + 1], length)
        legs.append(Leg(curve=Line(start=a, end=b), speed=SPEED, turning=turning))
    return legs


corners = st.lists(vectors(-1, 1), min_size=3, max_size=5)


@few
@given(points=corners, radii=st.lists(st.floats(0.001, 1.0), min_size=3, max_size=3), seed=st.integers(0, 99))
def test_a_route_is_smooth_passes_its_ends_and_rounds_corners_within_their_zones(points, radii, seed):
    points = np.array(points)
    steps = np.diff(points, axis=0)
    sides = np.linalg.norm(steps, axis=1)
    assume(sides.min() > 0.2)
    cosines = [a @ b / np.linalg.norm(a) / np.linalg.norm(b) for a, b in itertools.pairwise(steps)]
    assume(min(cosines) > -0.9 and max(cosines) < 0.99)
    turns = Rotation.random(len(points), rng=seed).as_matrix()
    zones = radii[: len(points) - 2]
    route, targets = round_corners(lines(points, turns), zones)
    s = np.linspace(0, route.ends[-1], 8001)
    course = route.at(s)
    position, tangent, bend, _ = course.path
    rotation, rate, change = course.turned
    step = s[1]
    np.testing.assert_allclose(position[[0, -1]], points[[0, -1]], atol=1e-9)
    np.testing.assert_allclose(rotation[[0, -1]], turns[[0, -1]], atol=1e-9)
    third = np.abs(route.at(s).path[3]).max() + 1
    np.testing.assert_allclose(central(position, step), tangent[1:-1], atol=third * step**2 + 1e-7)
    np.testing.assert_allclose(central(tangent, step), bend[1:-1], atol=2 * third * step)
    moved = Rotation.from_matrix(rotation[2:] @ rotation[:-2].swapaxes(1, 2)).as_rotvec() / (2 * step)
    np.testing.assert_allclose(moved, rate[1:-1], atol=2 * step * (np.abs(change).max() + 1))
    for i, (radius, target) in enumerate(zip(radii, targets[:-1], strict=False)):
        reach = min(radius, 0.5 * sides[i], 0.5 * sides[i + 1])
        passed = np.linalg.norm(route.at(np.array([target])).path[0][0] - points[i + 1])
        assert 0 < passed < reach
        on_lines = np.min([_distance(position, a, b) for a, b in itertools.pairwise(points)], axis=0)
        near = np.min(np.linalg.norm(position[:, None] - points[1:-1], axis=2), axis=1)
        assert np.all((on_lines < 1e-9) | (near <= max(radii) * (1 + 1e-9)))


def _distance(points, start, end):
    along = np.clip((points - start) @ (end - start) / ((end - start) @ (end - start)), 0, 1)[:, None]
    return np.linalg.norm(points - start - along * (end - start), axis=1)


def test_zones_that_overlap_shrink_to_half_of_the_shorter_leg():
    route, targets = round_corners(lines([(0, 0, 0), (0.1, 0, 0), (0.1, 1, 0)]), [0.5])
    assert [round(leg.curve.length, 9) for leg in route.legs[::2]] == [0.05, 0.95]
    assert len(targets) == 2


def test_legs_that_go_on_smoothly_are_not_rounded():
    arc = arc_about(np.zeros(3), np.array([1.0, 0, 0]), np.array([0, 0, 1.0]), 2.0)
    halves = [Leg(curve=Part(curve=arc, start=a, end=a + 1.0), speed=SPEED) for a in (0.0, 1.0)]
    assert meets(*halves)
    route, targets = round_corners(halves, [0.1])
    assert len(route.legs) == 2
    np.testing.assert_array_equal(targets, [1, 2])


def test_a_jump_in_curvature_or_turning_needs_a_rounded_corner():
    line = lines([(-1, 0, 0), (0, 0, 0)])[0]
    arc = Leg(curve=arc_about(np.array([0, 1.0, 0]), np.zeros(3), np.array([0, 0, 1.0]), 1.0), speed=SPEED)
    assert not meets(line, arc)
    still, turning = lines([(-1, 0, 0), (0, 0, 0), (1, 0, 0)], Rotation.random(3, rng=0).as_matrix())
    assert not meets(still, turning)
    straight = lines([(-1, 0, 0), (0, 0, 0), (1, 0, 0)], np.stack([np.eye(3)] * 3))
    assert meets(*straight)


def test_the_corner_takes_the_lower_speed_of_its_legs():
    legs = lines([(0, 0, 0), (1, 0, 0), (1, 1, 0)])
    legs[1] = Leg(curve=legs[1].curve, speed=Speed(tcp=0.05, turn=100.0))
    route, _ = round_corners(legs, [0.1])
    assert route.legs[1].speed == Speed(tcp=0.05, turn=SPEED.turn)


def test_corner_angles_are_right_to_the_last_degree():
    for degrees in (0.0, 1e-4, 45.0, 90.0, 179.9999, 180.0):
        angle = np.deg2rad(degrees)
        first, second = lines([(-1, 0, 0), (0, 0, 0), (np.cos(angle), np.sin(angle), 0)])
        assert corner_angle(first.curve, second.curve) == pytest.approx(angle, abs=1e-12)


def test_a_spline_of_orientations_is_not_rounded():
    first, second = lines([(0, 0, 0), (1, 0, 0), (1, 1, 0)], np.stack([np.eye(3)] * 3))
    spline = SplineTurn(knots=np.array([0.0, 1.0]), rotations=np.stack([np.eye(3)] * 2))
    assert isinstance(first.turning, EvenTurn)
    with pytest.raises(FFGymError, match="stop before and after a spline"):
        round_corners([first, Leg(curve=second.curve, speed=SPEED, turning=spline)], [0.1])
