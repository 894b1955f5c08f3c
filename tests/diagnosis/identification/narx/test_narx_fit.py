"""Fits of NARX networks: they recover a network of their kind, in prediction and in free run."""

from dataclasses import replace

import numpy as np
import pytest
from narx_forms import FORMS
from scipy.optimize import check_grad

from ffgym.core.errors import FFGymError
from ffgym.diagnosis.identification.narx import Errors, Misfit, Structure, best_simulating, fit_network
from ffgym.diagnosis.identification.narx.fit import _pack
from ffgym.diagnosis.identification.narx.problems import Prediction, Simulation


def fit_to(record, form, n_starts=5, **how):
    structure = Structure(regressors=FORMS[form])
    return best_simulating([record], structure, np.random.default_rng(0), n_starts, n_evaluations=200, **how)


@pytest.mark.parametrize("form", ["(6.19)", "(6.20)", "slip"])
def test_a_fit_predicts_what_a_network_of_its_kind_made(form, network, sweep, samples_of):
    made = samples_of(sweep(), network(FORMS[form], seed=3).simulate(sweep()))
    errors = Errors.of(fit_to(made, form), made)
    assert np.all(errors.prediction.share < 0.05)
    assert np.all(errors.simulation.share < 0.1)


def test_of_several_starts_the_one_stays_that_simulates_best(network, sweep, samples_of):
    made = samples_of(sweep(), network(seed=3).simulate(sweep()))
    one, three = (Errors.of(fit_to(made, "(6.20)", n), made).simulation.rms for n in (1, 3))
    assert np.all(three <= one)  # the first start is the same
    assert np.any(three < one)


def test_a_fit_to_the_simulation_simulates_better_than_one_to_the_prediction(network, sweep, samples_of):
    v = sweep(150)
    made = samples_of(v, network(FORMS["all"], seed=3).simulate(v) + 0.05 * np.sin(v))
    by_prediction = fit_to(made, "(6.20)", 1)
    by_simulation = fit_to(made, "(6.20)", 1, focus="simulation")
    before, after = (Errors.of(model, made) for model in (by_prediction, by_simulation))
    assert np.all(after.simulation.rms < 0.98 * before.simulation.rms)
    assert np.all(after.prediction.rms > before.prediction.rms)


@pytest.mark.parametrize(
    ("problem", "form"),
    [(Prediction, "slip"), (Prediction, "all"), (Simulation, "(6.20)"), (Simulation, "long"), (Simulation, "all")],
)
def test_slopes_are_those_of_the_errors(problem, form, network, sweep, samples_of):
    model, record = network(FORMS[form], size=0.7), samples_of(sweep(80), np.sin(sweep(80)))
    record = replace(record, scored=np.arange(80) % 3 == 0)
    posed, parameters = problem(model, [record, record], 1), _pack(model, 1)

    def of_cost(p):
        return posed.residual(p) @ posed.residual(p)

    def slope_of_cost(p):
        return 2 * posed.jacobian(p).T @ posed.residual(p)

    size = np.linalg.norm(slope_of_cost(parameters))
    assert check_grad(of_cost, slope_of_cost, parameters) < 1e-5 * size


@pytest.mark.parametrize("problem", [Prediction, Simulation])
def test_errors_that_are_minimised_are_those_of_the_network(problem, network, sweep, samples_of):
    model, record = network(FORMS["all"]), samples_of(sweep(50), np.sin(sweep(50)))
    torque = {
        Prediction: model.predict(record.motor_dq, record.torque),
        Simulation: model.simulate(record.motor_dq),
    }[problem]
    for j in range(model.n_joints):
        expected = (torque - record.torque)[:, j] / record.noise[j]
        np.testing.assert_allclose(problem(model, [record], j).residual(_pack(model, j)), expected, rtol=0, atol=1e-9)


def test_slopes_of_a_network_that_amplifies_its_errors_stay_numbers(network, samples_of):
    model = network()
    model = replace(model, input_weights=0 * model.input_weights + [0.0, 8.0], biases=0 * model.biases)
    model = replace(model, output_weights=0 * model.output_weights + 2.0, offset=np.full(2, -3.0))
    rest = samples_of(np.zeros((2000, 2)), np.zeros((2000, 2)))
    jacobian = Simulation(model, [rest], 0).jacobian(_pack(model, 0))
    assert np.abs(jacobian).max() > 1e50
    assert np.all(np.isfinite(jacobian.T @ jacobian))


def test_samples_that_are_not_scored_count_for_nothing(network, sweep, samples_of):
    torque = network(FORMS["slip"], seed=3).simulate(sweep())
    record = replace(samples_of(sweep(), torque), scored=np.arange(600) < 300)
    other = torque.copy()
    other[300:] *= -1  # of the same size, which the fit takes from the whole motion
    fits = [fit_to(replace(record, torque=each), "slip", 1) for each in (torque, other)]
    np.testing.assert_array_equal(*(model.input_weights for model in fits))


def test_a_misfit_is_given_as_rms_as_share_and_as_fit():
    torque = np.array([[1.0], [3.0], [1.0], [3.0]])
    misfit = Misfit.of(torque + 0.5, torque)
    assert misfit.rms == pytest.approx([0.5])
    assert misfit.share == pytest.approx([0.5 / np.sqrt(5)])
    assert misfit.fit == pytest.approx([50.0])
    assert Misfit.of(np.full((4, 1), 2.0), torque).fit == pytest.approx([0.0])


def test_a_motor_whose_torque_does_not_change_has_an_rms_error_and_no_fit():
    misfit = Misfit.of(np.full((4, 2), 0.5), np.array([[0.0, 1.0]] * 4))
    assert misfit.rms.tolist() == [0.5, 0.5]
    assert np.isnan(misfit.fit).all()
    np.testing.assert_array_equal(misfit.share, [np.nan, 0.5])


def test_errors_on_samples_of_another_clock_are_refused(network, sweep, samples_of):
    with pytest.raises(FFGymError, match=r"fitted to samples every 0.004 s, these are 0.001 s apart"):
        Errors.of(network(), samples_of(sweep(50), sweep(50), dt=0.001))


def test_records_that_do_not_fit_together_are_refused(sweep, samples_of):
    one, rng = samples_of(sweep(50), sweep(50)), np.random.default_rng(0)
    with pytest.raises(FFGymError, match="no motion to fit"):
        fit_network([], Structure(), rng)
    with pytest.raises(FFGymError, match=r"different sample times \[s\]: \[0.001, 0.004\]"):
        fit_network([one, replace(one, dt=0.001)], Structure(), rng)
    with pytest.raises(FFGymError, match=r"different numbers of motors: \[1, 2\]"):
        fit_network([one, samples_of(sweep(50, 1), sweep(50, 1))], Structure(), rng)
    with pytest.raises(FFGymError, match="scored marks none"):
        replace(one, scored=np.zeros(50, dtype=np.bool_))
    with pytest.raises(FFGymError, match="scored has type int64 and shape"):
        replace(one, scored=np.ones(50, dtype=np.int64))  # as an index these would be rows 1, 1, 1, ...
    with pytest.raises(FFGymError, match="12 scored samples are too few for a NARX network of 13 weights"):
        fit_network([replace(one, scored=np.arange(50) < 12)], Structure(), rng)
    with pytest.raises(FFGymError, match="n_neurons = 0"):
        Structure(n_neurons=0)
    with pytest.raises(FFGymError, match="Unknown focus 'both'"):
        fit_network([one], Structure(), rng, focus="both")
