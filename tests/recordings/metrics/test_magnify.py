"""Errors drawn larger than they are."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ffgym.recordings.metrics import magnification, magnify


@given(room=st.floats(1e-6, 1e3), largest=st.floats(1e-9, 1e3))
def test_the_factor_is_round_and_as_large_as_there_is_room_for(room, largest):
    factor = magnification(room, largest)
    assert f"{factor:e}"[0] in "125"
    assert factor == 1 or room / 2.5 * (1 - 1e-6) <= factor * largest <= room * (1 + 1e-6)
    assert magnification(room, largest, 100.0) == min(factor, 100.0)


def test_without_an_error_the_factor_is_the_largest_or_one():
    assert (magnification(1.0, 0.0), magnification(1.0, 0.0, 50.0)) == (1.0, 50.0)


def test_only_the_error_is_enlarged():
    nearest, error = np.eye(3), np.full((3, 3), 0.1)
    np.testing.assert_allclose(magnify(nearest, error, 5.0), nearest + 0.5)
    assert magnify(nearest, error, 1.0) == pytest.approx(nearest + error)
