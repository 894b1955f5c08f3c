"""Checks pass what is valid unchanged and name what is not."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from ffgym.core.errors import FFGymError, check_choice, check_number, check_rotation, check_shape

damage = st.sampled_from([np.nan, np.inf, -np.inf, 10**400, [np.nan], [[1.0], [2.0, 3.0]], {}, "1"])
anything = (
    damage
    | st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text(max_size=3)
    | st.lists(st.floats(), max_size=3)
)


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_a_number_in_range_passes_unchanged(value):
    assert check_number("x", value) == value
    assert check_number("x", value, low=value, high=value) == value
    with pytest.raises(FFGymError, match=r"x = .* m is out of range, must be in \("):
        check_number("x", value, unit="m", low=value, open_low=True)


@given(anything)
def test_a_check_returns_a_finite_value_or_refuses_by_name(value):
    for check in (check_number, lambda name, v: check_shape(name, v, (None,)), check_rotation):
        try:
            result = check("thing", value)
        except FFGymError as error:
            assert str(error).startswith("thing ")  # noqa: PT017
        else:
            assert np.all(np.isfinite(result))


@given(st.lists(st.floats(-1e9, 1e9), min_size=1, max_size=5))
def test_a_shape_may_be_open(values):
    np.testing.assert_array_equal(check_shape("x", values, (None,)), values)
    np.testing.assert_array_equal(check_shape("x", [values], (1, None)), [values])
    with pytest.raises(FFGymError, match=r"x has shape \(\d,\), must be \(any, 3\)"):
        check_shape("x", values, (None, 3))


def test_the_first_entry_that_is_not_finite_is_named():
    with pytest.raises(FFGymError, match=r"x must be finite, but entry \(1, 0\) is nan"):
        check_shape("x", [[1.0, 2.0], [np.nan, np.inf]], (2, 2))


def test_plus_infinity_passes_where_it_may_stand_and_nothing_else_does():
    np.testing.assert_array_equal(check_shape("x", [1.0, np.inf], (2,), infinite=True), [1.0, np.inf])
    for bad in (np.nan, -np.inf):
        with pytest.raises(FFGymError, match=r"x must be finite, but entry \(1,\)"):
            check_shape("x", [np.inf, bad], (2,), infinite=True)


def test_numbers_behind_a_mask_are_not_taken():
    with pytest.raises(FFGymError, match="x has masked entries, must have a number everywhere"):
        check_shape("x", np.ma.masked_array([1.0, 2.0], mask=[False, True]), (2,))
    np.testing.assert_array_equal(check_shape("x", np.ma.masked_array([1.0, 2.0]), (2,)), [1.0, 2.0])


def test_an_error_about_a_large_array_stays_on_one_line():
    with pytest.raises(FFGymError, match="x must be numbers, got array") as caught:
        check_shape("x", np.full((40, 3), "none"), (40, 3))
    assert "\n" not in str(caught.value)


@given(st.integers(0, 2**32 - 1))
def test_rotations_pass_and_mirrors_and_scalings_do_not(seed):
    matrix = Rotation.random(random_state=seed).as_matrix()
    np.testing.assert_array_equal(check_rotation("turn", matrix), matrix)
    for bad in (-matrix, 1.001 * matrix, 1e200 * matrix, matrix @ np.diag([1, 1, 0])):
        with pytest.raises(FFGymError, match=r"turn = .* is not a rotation matrix"):
            check_rotation("turn", bad)


def test_a_choice_lists_what_there_is():
    assert check_choice("colour", "red", ["red", "blue"]) == "red"
    with pytest.raises(FFGymError, match=r"Unknown colour 'pink'\. Available: blue, red\."):
        check_choice("colour", "pink", ["red", "blue"])
