"""Networks over speed and position: thesis (3.12), and that they learn what curves of one input cannot."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ffgym.agents.bspline import StaticBSN
from ffgym.agents.law_files import load_law, save_law
from ffgym.agents.spline_basis import SplineBasis
from ffgym.agents.stability import LearningStability, learning_curves
from ffgym.agents.tensor_bspline import TensorBSN, even_positions
from ffgym.agents.trials import SimulatedTrial
from ffgym.core.errors import FFGymError
from ffgym.paths import joint_reference, joint_sine
from ffgym.robot import RigidArm
from tests.agents.lesson_samples import lesson

SPEEDS = SplineBasis(knots=np.linspace(-20, 20, 21))


@pytest.fixture(scope="module")
def axis(one_axis):
    return RigidArm(one_axis)


@pytest.fixture(scope="module")
def sine(one_axis):
    return joint_reference(one_axis, joint_sine([1.0], 1.0, 2.0))


def drawn(shape=(2, 9, 21), **fields):
    """A network of two joints with weights drawn at random, over -1 to 1 and 0 to 3 rad."""
    fields = {"positions": even_positions(shape[1]), "position_range": np.array([[-1.0, 0.0], [1.0, 3.0]]), **fields}
    return TensorBSN(coefficients=np.random.default_rng(3).normal(size=shape), basis=SPEEDS, **fields)


@given(st.floats(-25, 25), st.floats(-1, 2), st.integers(1, 4), st.integers(1, 4))
def test_the_products_add_up_to_one_and_each_is_a_spline_over_position_times_one_over_speed(speed, place, high, low):
    basis, positions = SplineBasis(knots=np.linspace(-20, 20, 9), order=high), even_positions(5, low)
    network = TensorBSN.zero(1, basis, positions=positions)
    values, numbers = network.active(np.array([speed]), np.zeros(1), np.array([place]))
    assert values.sum() == pytest.approx(1, abs=1e-12)
    assert values.min() >= 0
    by_speed, by_place = np.zeros(basis.n_splines), np.zeros(positions.n_splines)
    for splines, table, at in ((basis, by_speed, speed), (positions, by_place, place)):
        ones, where = splines.active(np.array([at]))
        table[where[0]] = ones[0]
    together = np.zeros(network.coefficients[0].size)
    together[numbers[0]] = values[0]
    np.testing.assert_allclose(together.reshape(positions.n_splines, -1), np.outer(by_place, by_speed), atol=1e-15)


def test_weights_that_do_not_depend_on_position_make_the_static_network():
    alone = StaticBSN(coefficients=np.random.default_rng(0).normal(size=(2, 1, 21)), basis=SPEEDS)
    both = drawn()
    both = both.with_weights({"coefficients": np.repeat(alone.coefficients, 9, axis=1)})
    speeds, q = np.random.default_rng(1).uniform(-25, 25, (2, 50, 2))
    np.testing.assert_allclose(both.torque_at(speeds, speeds, q), alone.torque_at(speeds, speeds), atol=1e-12)


def test_each_joint_has_a_range_of_its_own_and_keeps_its_last_torque_beyond():
    network = drawn()
    speeds = np.full((3, 2), 4.0)
    at_the_end = network.torque_at(speeds, speeds, np.array([[1.0, 3.0], [1.7, 3.5], [99.0, 99.0]]))
    np.testing.assert_array_equal(at_the_end[1:], at_the_end[[0, 0]])
    weights = network.coefficients[:, -1]  # of the last position spline; 4 rad/s is a knot, the 13th
    np.testing.assert_allclose(at_the_end[0], weights[:, 12], atol=1e-12)


def test_it_learns_friction_that_changes_with_position_which_no_sum_of_two_curves_can(sine):
    """A product of both inputs: least squares of a sum of two curves leaves most, updates of the network little."""
    dq, q = sine.motor_dq, sine.q
    wanted = dq / np.abs(dq).max() * (q - q.mean()) / np.abs(q - q.mean()).max()
    network = TensorBSN.along([sine], SPEEDS)
    for _ in range(60):
        network = network.adapt([lesson(sine, wanted - network.torque_at(dq, sine.motor_ddq, q))], 1.0)
    left = np.std(wanted - network.torque_at(dq, sine.motor_ddq, q)) / np.std(wanted)

    curves = [StaticBSN.zero(1, SPEEDS).design_matrix(dq[:, 0], dq[:, 0]).toarray()]
    values, numbers = even_positions(21).active(network.locate(q)[:, 0])
    curves.append(np.zeros((len(q), 21)))
    np.put_along_axis(curves[1], numbers, values, axis=1)
    additive = np.concatenate(curves, axis=1)
    rest = wanted[:, 0] - additive @ np.linalg.lstsq(additive, wanted[:, 0], rcond=None)[0]
    assert np.std(rest) > 0.9 * np.std(wanted)
    assert left < 0.05


def test_in_simulation_it_learns_and_as_predicted(axis, sine):
    network, trial = TensorBSN.along([sine]), SimulatedTrial(arm=axis, n_threads=1)
    limit = float(LearningStability.of(network, axis, [sine]).largest_rate[0])
    assert limit > 0.8
    (curves,) = learning_curves(network, trial, sine, [0.5 * limit], 6)
    assert curves.simulated[0, -1] < 0.2 * curves.simulated[0, 0]
    np.testing.assert_allclose(np.sqrt(curves.predicted), np.sqrt(curves.simulated), rtol=0.15, atol=0.03)


def test_everything_survives_a_file(tmp_path, sine):
    network = drawn(
        (1, 6, 21), position_range=np.array([[-1.0], [1.0]]), positions=even_positions(5, 3), normalised=False
    )
    again = load_law(save_law(tmp_path / "mine.npz", network))
    assert isinstance(again, TensorBSN)
    assert not again.normalised
    np.testing.assert_array_equal(again.torque(sine), network.torque(sine))


def test_bad_input_is_refused(sine):
    with pytest.raises(FFGymError, match=r"position_range = .* must rise on every joint"):
        drawn(position_range=np.array([[0.0, 0.0], [1.0, 0.0]]))
    with pytest.raises(FFGymError, match="coefficients"):
        drawn(positions=even_positions(4))
    with pytest.raises(FFGymError, match="give positions too"):
        drawn().torque_at(np.zeros(2), np.zeros(2))
    with pytest.raises(FFGymError, match="no motion to cover"):
        TensorBSN.along([])
    with pytest.raises(FFGymError, match="position knots = 1"):
        even_positions(1)
