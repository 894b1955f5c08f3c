"""Linear models of friction: they are the difference equation that they say, and fits recover one of their kind."""

from dataclasses import replace

import numpy as np
import pytest
from narx_forms import FORMS
from scipy.optimize import approx_fprime

from ffgym.core.errors import FFGymError
from ffgym.diagnosis.identification.narx import Errors, LinearModel, Regressors, fit_linear
from ffgym.diagnosis.identification.narx.linear import _Motor

SECOND_ORDER = Regressors(speed_lags=(0, 2), slip_widths=(0.01,), output_lags=(1, 2))


@pytest.fixture
def linear():
    """A model of two motors with stable poles."""
    return LinearModel(
        input_weights=np.array([[0.3, -0.1, 2.0], [0.2, 0.1, 1.0]]),
        output_weights=np.array([[1.2, -0.5], [0.6, 0.1]]),
        offset=np.array([0.05, -0.02]),
        regressors=SECOND_ORDER,
        dt=0.004,
    )


@pytest.fixture
def wild():
    """Function that gives motor speeds that excite every lag."""

    def make(rows=2000):
        return np.cumsum(np.random.default_rng(1).normal(size=(rows, 2)), axis=0) * 0.1

    return make


def test_free_run_is_the_difference_equation_and_begins_without_torque(linear, wild):
    v = wild(40)
    inputs, y = SECOND_ORDER.inputs(v, linear.dt, np.ones(2)), np.zeros((42, 2))  # two rows before the start
    for k in range(1, 40):
        for j in range(2):
            driven = linear.offset[j] + inputs[k, j] @ linear.input_weights[j]
            y[k + 2, j] = driven + linear.output_weights[j] @ y[[k + 1, k], j]
    np.testing.assert_allclose(linear.simulate(v), y[2:], rtol=0, atol=1e-12)


def test_one_step_ahead_past_outputs_are_the_measured_ones(linear, wild):
    v = wild(40)
    torque = linear.simulate(v)
    np.testing.assert_allclose(linear.predict(v, torque)[1:], torque[1:], rtol=0, atol=1e-12)
    off = torque + np.array([0.1, 0.1])  # a constant error of what was measured
    expected = torque + 0.1 * linear.output_weights.sum(axis=1)
    np.testing.assert_allclose(linear.predict(v, off)[3:], expected[3:], rtol=0, atol=1e-12)


@pytest.mark.parametrize("focus", ["prediction", "simulation"])
def test_a_fit_recovers_a_model_of_its_kind(focus, linear, wild, samples_of):
    v = wild()
    record = samples_of(v, linear.simulate(v))
    record = replace(record, scored=np.arange(len(v)) > 0)  # the first output is none, whatever the weights
    found = fit_linear([record], SECOND_ORDER, focus=focus)
    for name in ("input_weights", "output_weights", "offset"):
        np.testing.assert_allclose(getattr(found, name), getattr(linear, name), rtol=0, atol=1e-6)


def test_noise_of_the_output_biases_arx_and_not_output_error(linear, wild, samples_of):
    v = wild(20000)
    noise = 0.3 * np.random.default_rng(2).normal(size=v.shape)
    records = [samples_of(v, linear.simulate(v) + noise)]
    arx, oe = (fit_linear(records, SECOND_ORDER, focus=focus) for focus in ("prediction", "simulation"))
    off = [np.abs(model.output_weights - linear.output_weights).max() for model in (arx, oe)]
    assert off[1] < 0.05 < off[0]


@pytest.mark.parametrize("form", ["(6.20)", "long", "all"])
def test_output_error_leaves_less_in_free_run_and_more_one_step_ahead(form, network, sweep, samples_of):
    made = samples_of(sweep(), network(FORMS["all"], seed=3).simulate(sweep()))
    arx, oe = (Errors.of(fit_linear([made], FORMS[form], focus=f), made) for f in ("prediction", "simulation"))
    assert np.all(oe.simulation.rms < arx.simulation.rms)
    assert np.all(oe.prediction.rms > arx.prediction.rms)


def test_without_past_outputs_both_are_the_same(network, sweep, samples_of):
    made = samples_of(sweep(), network(seed=3).simulate(sweep()))
    arx, oe = (fit_linear([made], FORMS["slip"], focus=focus) for focus in ("prediction", "simulation"))
    np.testing.assert_array_equal(arx.input_weights, oe.input_weights)
    assert np.all(arx.largest_pole == 0)


def test_slopes_are_those_of_the_errors(linear, wild, samples_of):
    v = wild(60)
    record = replace(samples_of(v, np.sin(v)), scored=np.arange(60) % 3 == 0)
    motor = _Motor([record, record], SECOND_ORDER, 0)
    weights = np.array([0.3, -0.1, 2.0, 0.05, 1.2, -0.5])
    numerical = approx_fprime(weights, motor._residual, 1e-7)
    np.testing.assert_allclose(motor._jacobian(weights), numerical, rtol=0, atol=1e-4 * np.abs(numerical).max())


def test_output_error_is_stable_where_arx_is_not(wild, samples_of):
    v = wild(400)
    grows = LinearModel(
        input_weights=np.ones((2, 1)),
        output_weights=np.full((2, 1), 1.01),
        offset=np.zeros(2),
        regressors=Regressors(),
        dt=0.004,
    )
    record = samples_of(v, grows.simulate(v))
    arx, oe = (fit_linear([record], Regressors(), focus=focus) for focus in ("prediction", "simulation"))
    assert np.all(arx.largest_pole > 1.0)
    assert np.all(oe.largest_pole < 1.0)


def test_torque_that_runs_away_stays_a_number():
    model = LinearModel(
        input_weights=np.ones((1, 1)),
        output_weights=np.full((1, 1), -2.0),
        offset=np.zeros(1),
        regressors=Regressors(),
        dt=0.004,
    )
    assert np.all(np.abs(model.simulate(np.ones((3000, 1)))) <= 1e100)


def test_a_motor_that_stands_still_has_no_torque(samples_of):
    record = samples_of(np.zeros((50, 1)), np.zeros((50, 1)))
    for focus in ("prediction", "simulation"):
        assert not fit_linear([record], Regressors(), focus=focus).simulate(np.ones((5, 1))).any()


def test_what_cannot_be_fitted_is_refused(sweep, samples_of):
    record = samples_of(sweep(2), sweep(2))
    with pytest.raises(FFGymError, match="no motion to fit a linear model to"):
        fit_linear([], Regressors())
    with pytest.raises(FFGymError, match="2 scored samples are too few for a linear model of 3 weights"):
        fit_linear([record], Regressors())
    with pytest.raises(FFGymError, match="focus"):
        fit_linear([samples_of(sweep(20), sweep(20))], Regressors(), focus="both")
    with pytest.raises(FFGymError, match="output_weights"):
        LinearModel(
            input_weights=np.ones((1, 1)),
            output_weights=np.ones((1, 2)),
            offset=np.zeros(1),
            regressors=Regressors(),
            dt=0.004,
        )
    model = fit_linear([samples_of(sweep(20), sweep(20))], Regressors())
    with pytest.raises(FFGymError, match=r"fitted to samples every 0.004 s, these are 0.001 s apart"):
        Errors.of(model, samples_of(sweep(20), sweep(20), dt=0.001))


def test_a_fit_in_free_run_begins_with_poles_that_are_stable(wild, samples_of):
    motor = _Motor([samples_of(wild(9), wild(9))], Regressors(output_lags=(1, 3)), 0)
    weights = np.array([1.0, 0.0, 1.5, -0.9])  # of the speed, the offset, y(k-1), y(k-3)
    before, after = (np.roots(motor._denominator(each)) for each in (weights, motor._stabilise(weights)))
    assert np.abs(before).max() > 1.0
    np.testing.assert_allclose(after, before * 0.999 / np.abs(before).max(), rtol=1e-9)
    np.testing.assert_array_equal(motor._stabilise(0.1 * weights), 0.1 * weights)
