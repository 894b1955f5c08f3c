"""The spline basis: what thesis 3.2.1 says of it, for any knots and order."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ffgym.agents.bspline import SplineBasis, thesis_knots
from ffgym.core.errors import FFGymError

bases = st.builds(
    lambda start, steps, order: SplineBasis(knots=start + np.cumsum(steps), order=order),
    st.floats(-20, 20),
    st.lists(st.floats(0.01, 3.0), min_size=2, max_size=12),
    st.integers(1, 5),
)
places = st.floats(0, 1)


def within(basis: SplineBasis, place: float) -> np.ndarray:
    """The speed at `place` of the basis' interval, 0 is its start."""
    speed = basis.knots[0] + place * np.ptp(basis.knots)
    return np.array([min(speed, basis.knots[-1])])  # which rounding could pass


def dense(basis: SplineBasis, speeds: np.ndarray) -> np.ndarray:
    """Every spline at `speeds` (T,), shape (T, S)."""
    values, numbers = basis.active(speeds)
    table = np.zeros((len(speeds), basis.n_splines))
    np.put_along_axis(table, numbers, values, axis=1)
    return table


@given(bases, places)
def test_the_splines_add_up_to_one_and_none_is_negative(basis, place):
    values, _ = basis.active(within(basis, place))
    assert values.sum() == pytest.approx(1, abs=1e-12)
    assert values.min() >= 0


@given(bases, places)
def test_a_spline_is_zero_outside_its_own_knots(basis, place):
    speed = within(basis, place)
    values, numbers = basis.active(speed)
    for value, number in zip(values[0], numbers[0], strict=True):
        first, last = basis.clamped[number], basis.clamped[number + basis.order]
        assert value == pytest.approx(0, abs=1e-12) or first <= speed[0] <= last


@given(bases, st.lists(st.floats(0, 0.999), min_size=1, max_size=20))
def test_inside_the_clamped_knots_the_splines_are_those_of_the_recursion(basis, marks):
    """Thesis (3.9) and (3.11), with lambda_{i+j-1} and lambda_{i+j} in the denominators: (3.11) counts one too far."""
    speeds = np.concatenate([within(basis, mark) for mark in marks])
    knots = basis.clamped

    def ratio(above, below):
        return np.divide(above, below, out=np.zeros_like(above), where=below != 0)

    def spline(i, j):
        if j == 1:
            return ((knots[i] <= speeds) & (speeds < knots[i + 1])).astype(float)
        rising = ratio(speeds - knots[i], np.full_like(speeds, knots[i + j - 1] - knots[i]))
        falling = ratio(knots[i + j] - speeds, np.full_like(speeds, knots[i + j] - knots[i + 1]))
        return rising * spline(i, j - 1) + falling * spline(i + 1, j - 1)

    recursion = np.stack([spline(i, basis.order) for i in range(basis.n_splines)], axis=1)
    np.testing.assert_allclose(dense(basis, speeds), recursion, rtol=0, atol=1e-9)


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_the_error_of_a_smooth_curve_falls_with_the_order_th_power_of_the_knot_distance(order):
    speeds = np.linspace(-1, 1, 2001)
    errors = []
    for n_knots in (21, 41):
        splines = dense(SplineBasis(knots=np.linspace(-1, 1, n_knots), order=order), speeds)
        weights = np.linalg.lstsq(splines, np.sin(2 * speeds), rcond=None)[0]
        errors.append(np.abs(splines @ weights - np.sin(2 * speeds)).max())
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.2)


@given(bases, st.floats(0.001, 100))
def test_beyond_the_outermost_knots_the_last_value_stays(basis, distance):
    first, last = basis.knots[0], basis.knots[-1]
    np.testing.assert_array_equal(
        dense(basis, np.array([first - distance, last + distance])), dense(basis, np.array([first, last]))
    )


def test_the_knots_are_those_of_thesis_5_1_1():
    knots = thesis_knots()
    assert len(knots) == 79
    assert SplineBasis().n_splines == 79
    inner = knots[np.abs(knots) <= 1 + 1e-12]
    np.testing.assert_allclose(inner, np.linspace(-1, 1, 41), atol=1e-12)
    np.testing.assert_allclose(knots[60:], np.arange(2, 21))
    np.testing.assert_allclose(knots, -knots[::-1], atol=1e-12)


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_centres_are_where_the_weights_of_a_straight_line_lie_on_it(order):
    basis = SplineBasis(knots=np.array([-2.0, -1.0, 0.5, 3.0]), order=order)
    assert basis.centres.shape == (basis.n_splines,)
    if order > 1:  # steps make no straight line
        speeds = np.linspace(-2, 3, 50)
        np.testing.assert_allclose(dense(basis, speeds) @ (1 + 2 * basis.centres), 1 + 2 * speeds, atol=1e-12)


@pytest.mark.parametrize("knots", [[], [1.0], [0.0, 0.0], [1.0, 0.5], [0.0, float("nan")]])
def test_knots_that_do_not_ascend_are_refused(knots):
    with pytest.raises(FFGymError, match="knots"):
        SplineBasis(knots=np.array(knots))


def test_an_order_below_one_is_refused():
    with pytest.raises(FFGymError, match="order = 0"):
        SplineBasis(order=0)
