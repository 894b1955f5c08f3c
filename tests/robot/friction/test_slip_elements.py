"""Slip elements: bounded, of one path only, with memory of the last turns."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from ffgym.robot.friction import WIDTHS, slip_along

DT = 0.004
SPEEDS = arrays(np.float64, (50, 2), elements=st.floats(-20, 20))


@given(SPEEDS)
def test_an_element_never_leaves_its_bounds(motor_dq):
    slip = slip_along(motor_dq, DT)
    assert np.abs(slip).max() <= 1


@given(SPEEDS)
def test_elements_of_the_opposite_motion_are_opposite(motor_dq):
    np.testing.assert_allclose(slip_along(-motor_dq, DT), -slip_along(motor_dq, DT), atol=1e-12)


def test_an_element_bends_with_the_travel_and_slips_beyond_its_width():
    dq = np.full((50, 1), 0.1)
    travel = 0.1 * DT * np.arange(50)
    np.testing.assert_allclose(slip_along(dq, DT)[:, 0], np.minimum(travel[:, None] / WIDTHS, 1), rtol=0, atol=1e-12)


def test_it_does_not_matter_how_fast_a_motor_turns_but_how_far():
    fast = slip_along(np.repeat([[0.4], [-0.2]], [20, 30], axis=0), DT)[-1]
    slow = slip_along(np.repeat([[0.1], [-0.05]], [80, 120], axis=0), DT)[-1]
    np.testing.assert_allclose(fast, slow, atol=0.05)


def test_a_small_turn_back_and_forth_leaves_no_trace():
    """The loop within the loop closes, as Masing's rules ask of friction."""
    up = np.full((40, 1), 0.1)
    there_and_back = np.concatenate([up, -up[:20], up[:20], up])
    straight = np.concatenate([up, up])
    np.testing.assert_allclose(slip_along(there_and_back, DT)[-1], slip_along(straight, DT)[-1], rtol=0, atol=0.15)
