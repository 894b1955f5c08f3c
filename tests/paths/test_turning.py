"""Orientation along a curve: rates are derivatives, and a rounded corner joins the turns of its legs."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from path_differences import central
from path_samples import vectors
from scipy.spatial.transform import Rotation

from ffgym.paths.route import BlendedTurn, EvenTurn, SplineTurn, even_turn

few = settings(max_examples=25)
turns = vectors(-2.5, 2.5)


def matrix(vector):
    return Rotation.from_rotvec(vector).as_matrix()


def check_rates(turning, length, *, kinks=()):
    s = np.linspace(0, length, 4001)
    step = s[1]
    rotation, rate, change = turning.at(s)
    moved = Rotation.from_matrix(rotation[2:] @ rotation[:-2].swapaxes(1, 2)).as_rotvec() / (2 * step)
    size = np.abs(change).max() + 1e-3
    np.testing.assert_allclose(moved, rate[1:-1], atol=2 * step * size)
    smooth = np.all([np.abs(s[1:-1] - kink) > 2 * step for kink in kinks] or [s[1:-1] >= 0], axis=0)
    np.testing.assert_allclose(central(rate, step)[smooth], change[1:-1][smooth], atol=0.01 * size)


@few
@given(start=turns, end=turns, length=st.floats(0.1, 3))
def test_an_even_turn_goes_the_short_way_from_one_orientation_to_the_other(start, end, length):
    turning = even_turn(matrix(start), matrix(end), length)
    check_rates(turning, length)
    np.testing.assert_allclose(turning.at(np.array([0.0, length]))[0], [matrix(start), matrix(end)], atol=1e-12)
    assert np.linalg.norm(turning.rate) * length <= np.pi + 1e-9


@few
@given(corner=turns, before=turns, after=turns, leg=st.floats(0.1, 1), share=st.floats(0.6, 1))
def test_a_blended_turn_starts_and_ends_as_its_legs(corner, before, after, leg, share):
    length = 2 * share * leg
    middle = matrix(corner)
    first = EvenTurn(start=matrix(-leg * np.array(before)) @ middle, rate=np.array(before))
    second = EvenTurn(start=middle, rate=np.array(after))
    turning = BlendedTurn(corner=middle, before=first.rate, after=second.rate, cut=leg, length=length)
    check_rates(turning, length)
    ends = turning.at(np.array([0.0, length]))
    begun, ended = first.at(np.zeros(1)), second.at(np.array([leg]))
    for part, one, other in zip(ends, begun, ended, strict=True):
        np.testing.assert_allclose(part, [one[0], other[0]], atol=1e-9)


def test_a_spline_of_orientations_passes_them_smoothly():
    rotations = Rotation.random(5, rng=1).as_matrix()
    knots = np.array([0.0, 0.7, 1.0, 2.5, 3.0])
    turning = SplineTurn(knots=knots, rotations=rotations)
    np.testing.assert_allclose(turning.at(knots)[0], rotations, atol=1e-12)
    check_rates(turning, 3.0, kinks=knots)


def test_a_turn_of_nothing_keeps_the_orientation():
    turning = even_turn(matrix([0.1, 0.2, 0.3]), matrix([0.1, 0.2, 0.3]), 1.0)
    assert np.linalg.norm(turning.rate) == pytest.approx(0, abs=1e-12)
