"""B-spline networks: which curve they add, and that an update follows the gradient.

The spline basis: what thesis 3.2.1 says of it, for any knots and order.
"""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ffgym.agents.bspline import ExtendedBSN, StaticBSN
from ffgym.agents.law_files import load_law, save_law
from ffgym.agents.spline_basis import SplineBasis, thesis_knots
from ffgym.core.errors import FFGymError
from ffgym.studies import sine_references
from tests.agents.lesson_samples import lesson

NETWORKS = [StaticBSN, ExtendedBSN]


@pytest.fixture(scope="module")
def sine(one_axis):
    return sine_references(one_axis, [1.0])[1.0]


@pytest.fixture
def random_network():
    """Function of a class and number of joints that returns a network with weights drawn at random."""

    def make(kind, n_joints=1, order=2):
        empty = kind.zero(n_joints, SplineBasis(order=order))
        return replace(empty, coefficients=np.random.default_rng(1).normal(size=empty.coefficients.shape))

    return make


def test_the_extended_network_asks_its_first_network_where_the_acceleration_is_not_negative():
    halves = np.stack([np.full((3, 79), 1.0), np.full((3, 79), -2.0)], axis=1)
    network = ExtendedBSN(coefficients=halves)
    np.testing.assert_allclose(network.torque_at(np.array([0.3, -5, 40]), np.array([0.0, 2.0, -1e-9])), [1, 1, -2])


def test_joints_have_weights_of_their_own(random_network):
    network = random_network(StaticBSN, n_joints=3)
    speeds = np.random.default_rng(0).uniform(-20, 20, (40, 3))
    together = network.torque_at(speeds, np.zeros_like(speeds))
    for joint in range(3):
        alone = replace(network, coefficients=network.coefficients[[joint]])
        np.testing.assert_array_equal(together[:, [joint]], alone.torque_at(speeds[:, [joint]], np.zeros((40, 1))))


@pytest.mark.parametrize("kind", NETWORKS)
@pytest.mark.parametrize("order", [1, 2, 3])
def test_torque_is_the_design_matrix_times_the_weights(kind, order, sine, random_network):
    network = random_network(kind, order=order)
    matrix = network.design_matrix(sine.motor_dq[:, 0], sine.motor_ddq[:, 0])
    torque = network.torque_at(sine.motor_dq, sine.motor_ddq)[:, 0]
    np.testing.assert_allclose(matrix @ network.coefficients.ravel(), torque, rtol=0, atol=1e-12)


@pytest.mark.parametrize("kind", NETWORKS)
def test_the_torque_of_a_sample_belongs_to_the_speed_and_acceleration_there(kind, sine, random_network):
    network = random_network(kind)
    expected = network.torque_at(sine.motor_dq, sine.motor_ddq)
    np.testing.assert_array_equal(network.torque(sine)[1:], expected[1:])


@pytest.mark.parametrize("kind", NETWORKS)
def test_the_update_is_the_gradient_of_the_quadratic_cost_over_the_sum_of_each_spline(kind, sine, random_network):
    """(3.16) and (5.5): -dJ/dw by finite differences, J = 1/2 sum (y_m - y)^2, where the signal is y_m - y."""
    network = random_network(kind)
    wanted = 2 * np.sin(3 * sine.motor_dq)

    def missing(weights):
        return wanted - replace(network, coefficients=weights).torque_at(sine.motor_dq, sine.motor_ddq)

    weights, eps = network.coefficients, 1e-4
    gradient = np.zeros_like(weights)
    for place in np.ndindex(weights.shape):
        nudge = np.zeros_like(weights)
        nudge[place] = eps
        gradient[place] = (np.sum(missing(weights + nudge) ** 2) - np.sum(missing(weights - nudge) ** 2)) / (4 * eps)
    seen = network.design_matrix(sine.motor_dq[:, 0], sine.motor_ddq[:, 0]).sum(axis=0).reshape(weights.shape)
    step = network.adapt([lesson(sine, missing(weights))], 0.7).coefficients - weights
    np.testing.assert_allclose(step * seen, -0.7 * gradient, rtol=0, atol=1e-6)
    assert np.abs(gradient).max() > 1


@pytest.mark.parametrize("kind", NETWORKS)
def test_the_update_that_is_not_normalised_is_the_gradient_itself(kind, sine, random_network, tmp_path):
    """(3.16): rate times the sum over samples of signal times spline, for each weight by itself."""
    network = replace(random_network(kind), normalised=False)
    signal = np.cos(3 * sine.motor_dq)
    sums = np.zeros(network.coefficients[0].size)
    for dq, ddq, z in zip(sine.motor_dq, sine.motor_ddq, signal[:, 0], strict=True):
        values, places = network.active(dq, ddq)
        sums[places[0]] += z * values[0]
    step = network.adapt([lesson(sine, signal)], 0.01).coefficients - network.coefficients
    np.testing.assert_allclose(step.ravel(), 0.01 * sums, rtol=0, atol=1e-10)
    assert np.abs(step).max() > 0.5  # the sum of many samples at a rate of 0.01
    assert load_law(save_law(tmp_path / "mine.npz", network)).normalised is False


@pytest.mark.parametrize("kind", NETWORKS)
def test_several_lessons_count_as_one_long_one(kind, sine, random_network):
    network = random_network(kind)
    signal = np.cos(sine.motor_dq)
    half = len(signal) // 2
    first = lesson(sine, signal[:half])
    second = lesson(sine, signal[half:], motor_dq=sine.motor_dq[half:], motor_ddq=sine.motor_ddq[half:])
    whole = network.adapt([lesson(sine, signal)], 0.5)
    np.testing.assert_allclose(network.adapt([first, second], 0.5).coefficients, whole.coefficients, rtol=0, atol=1e-12)


@pytest.mark.parametrize("kind", NETWORKS)
def test_speeds_that_were_not_seen_and_standstill_keep_their_weights(kind, sine, random_network):
    network = random_network(kind)
    speeds = np.linspace(2, 4, 201)[:, None]
    moving = speeds[:, 0] > 3
    update = network.adapt(
        [lesson(sine, np.ones_like(speeds), motor_dq=speeds, motor_ddq=np.ones_like(speeds), moving=moving)], 0.9
    )
    changed = np.argwhere(update.coefficients != network.coefficients)
    knots = network.basis.knots[changed[:, 2]]
    np.testing.assert_allclose(knots, [3, 4])
    np.testing.assert_allclose((update.coefficients - network.coefficients)[tuple(changed.T)], 0.9)
    assert set(changed[:, 1]) == {0}


@pytest.mark.parametrize("order", [1, 2, 3])
def test_a_network_can_start_from_a_curve(order):
    network = ExtendedBSN.zero(2, SplineBasis(order=order)).with_curve(lambda v: np.array([1.0, -2.0]) * np.tanh(v))
    speeds = np.repeat(np.linspace(-0.9, 0.9, 361)[:, None], 2, axis=1)
    for acceleration in (1.0, -1.0):
        torque = network.torque_at(speeds, np.full_like(speeds, acceleration))
        tolerance = {1: 0.06, 2: 1e-3, 3: 2e-3}[order]  # knots are 0.05 rad/s apart
        np.testing.assert_allclose(torque, np.array([1.0, -2.0]) * np.tanh(speeds), rtol=0, atol=tolerance)


@pytest.mark.parametrize("kind", NETWORKS)
def test_any_knots_order_and_name_survive_a_file(kind, tmp_path, sine):
    basis = SplineBasis(knots=np.array([-7.0, -1.0, 0.25, 7.0]), order=3)
    network = replace(kind.zero(1, basis, name="mine"), coefficients=np.random.default_rng(2).normal(
        size=(1, kind.n_networks, basis.n_splines)
    ))  # fmt: skip
    again = load_law(save_law(tmp_path / "mine.npz", network))
    assert isinstance(again, kind)
    assert again.name == "mine"
    np.testing.assert_array_equal(again.torque(sine), network.torque(sine))


def test_merging_takes_the_chosen_joints_from_the_other():
    mine, theirs = StaticBSN.zero(3), StaticBSN(coefficients=np.ones((3, 1, 79)))
    merged = mine.merge(theirs, np.array([True, False, True]))
    np.testing.assert_array_equal(merged.coefficients[:, 0, 0], [1, 0, 1])


@pytest.mark.parametrize("shape", [(0, 1, 79), (2, 2, 79), (2, 1, 78), (2, 79)])
def test_weights_of_another_shape_are_refused(shape):
    with pytest.raises(FFGymError, match="coefficients"):
        StaticBSN(coefficients=np.zeros(shape))


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
