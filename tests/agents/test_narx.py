"""NARX networks: structure, boundedness, memory, and fits that recover a known network."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agents.catalogue import Setting
from agents.fitting.narx_fit import Errors, Structure, fitted, learn_narx
from agents.fitting.supervised import MotorRecord
from agents.narx import NARX, sigmoid
from ffgym.control import Window
from ffgym.errors import FFGymError
from ffgym.simulation import Run
from ffgym.studies import sine_references

FORMS = {
    "(6.19)": Structure(n_speeds=2, n_outputs=0),
    "(6.20)": Structure(),
    "long": Structure(n_speeds=3, n_outputs=2),
}


def network(structure, seed=0, n=2):
    rng = np.random.default_rng(seed)
    shape = (n, structure.n_neurons, structure.n_speeds + structure.n_outputs)
    return NARX(
        input_weights=2 * rng.normal(size=shape),
        biases=rng.normal(size=shape[:2]),
        output_weights=rng.normal(size=shape[:2]),
        offset=rng.normal(size=n),
        speed_scale=np.full(n, 2.0),
        torque_scale=np.full(n, 0.5),
        n_speeds=structure.n_speeds,
    )


def sweep(n=2, rows=600):
    t = 0.004 * np.arange(rows)
    return np.stack([2 * np.sin(2 * np.pi * (0.5 + 0.2 * j) * t) for j in range(n)], axis=-1)


def record(motor_dq, torque):
    rows, n = motor_dq.shape
    return MotorRecord(
        dt=0.004,
        motor_dq=motor_dq,
        motor_ddq=np.zeros_like(motor_dq),
        slip=np.zeros((rows, n, 5)),
        torque=torque,
        moving=np.ones(rows, dtype=np.bool_),
        noise=np.full(n, 0.01),
        error=np.zeros(n),
    )


def test_the_sigmoid_is_the_one_of_the_thesis_and_does_not_overflow():
    x = np.linspace(-30, 30, 61)
    np.testing.assert_allclose(sigmoid(x), 1 / (1 + np.exp(-x)), rtol=0, atol=1e-15)
    assert sigmoid(np.array([-1e6, 1e6])).tolist() == [0, 1]


@pytest.mark.parametrize("form", FORMS)
def test_simulation_is_the_recursion_written_out(form):
    law, v = network(FORMS[form]), sweep(rows=40)
    y, u = np.zeros((40, 2)), v / law.speed_scale
    for k in range(1, 40):
        past = [u[max(k - i, 0)] for i in range(law.n_speeds)]
        past += [y[k - i] if k >= i else np.zeros(2) for i in range(1, FORMS[form].n_outputs + 1)]
        for j in range(2):
            inside = law.input_weights[j] @ [p[j] for p in past] + law.biases[j]
            y[k, j] = law.offset[j] + law.output_weights[j] @ (1 / (1 + np.exp(-inside)))
    np.testing.assert_allclose(law.simulated(v), law.torque_scale * y, rtol=0, atol=1e-12)


@given(st.integers(0, 1000), st.floats(0, 1e3))
@settings(max_examples=25)
def test_torque_stays_bounded_whatever_the_weights_and_the_motion(seed, size):
    law = network(FORMS["long"], seed)
    v = size * np.random.default_rng(seed).normal(size=(300, 2))
    assert np.all(np.abs(law.simulated(v)) <= law.bound + 1e-12)


def test_past_outputs_remember_and_past_speeds_do_not():
    v = sweep(rows=100)
    other = v.copy()
    other[:50] *= -1
    for form, remembers in (("(6.19)", False), ("(6.20)", True)):
        law = network(FORMS[form])
        law = replace(law, input_weights=0.5 * law.input_weights)
        apart = np.abs(law.simulated(v) - law.simulated(other))[52:]
        assert (apart.max() > 1e-9) == remembers


@pytest.mark.parametrize("form", FORMS)
def test_rows_of_a_batch_do_not_touch_each_other(form):
    law = network(FORMS[form])
    dq = sweep(rows=14).reshape(7, 2, 2)
    window = Window(q=0 * dq, motor_dq=dq, motor_ddq=0 * dq, dt=0.004)
    together, memory = law.step(law.initial_memory(window), window)
    for row in range(7):
        torque, alone = law.step(law.initial_memory(window[row]), window[row])
        np.testing.assert_allclose(together[row], torque, rtol=0, atol=1e-12)
        np.testing.assert_allclose(memory[row], alone, rtol=0, atol=1e-12)


@pytest.mark.parametrize("form", ["(6.19)", "(6.20)"])
def test_a_fit_predicts_what_a_network_of_its_kind_made(form):
    made = record(sweep(), network(FORMS[form], seed=3).simulated(sweep()))
    law = fitted([made], np.random.default_rng(0), FORMS[form])
    errors = Errors.of(law, made)
    assert np.all(errors.prediction < 0.05)
    assert np.all(errors.simulation < 0.1)


def test_of_several_starts_the_one_stays_that_simulates_best():
    made = record(sweep(), network(FORMS["(6.20)"], seed=3).simulated(sweep()))
    one, three = (
        Errors.of(fitted([made], np.random.default_rng(0), Structure(), n_starts=n), made).simulation for n in (1, 3)
    )
    assert np.all(three <= one)  # the first start is the same
    assert np.any(three < one)


def test_prediction_looks_better_than_simulation(one_axis):
    """Thesis 6.2.3, and the reason why a fit is judged by its simulation here."""
    setting, reference = Setting.of(one_axis), sine_references(one_axis)[1.0]
    learned = learn_narx(setting.trial, [reference], np.random.default_rng(0), n_trials=1)
    (recording,) = setting.trial([Run(reference=reference)], 0)
    errors = Errors.of(learned.law, MotorRecord.of(reference, recording))
    assert errors.prediction[0] < 0.5 * errors.simulation[0]
    assert errors.simulation[0] < 0.5


def test_without_past_outputs_prediction_is_simulation():
    made = record(sweep(), network(FORMS["(6.19)"]).simulated(sweep()))
    law = network(FORMS["(6.19)"], seed=1)
    np.testing.assert_allclose(law.predicted(made.motor_dq, made.torque)[1:], law.simulated(made.motor_dq)[1:])


def test_what_makes_no_network_is_refused():
    law = network(FORMS["(6.20)"])
    with pytest.raises(FFGymError, match=r"n_speeds = 3"):
        replace(law, n_speeds=3)
    with pytest.raises(FFGymError, match=r"speed_scale = .* must be > 0"):
        replace(law, speed_scale=np.zeros(2))
    with pytest.raises(FFGymError, match="n_neurons = 0"):
        Structure(n_neurons=0)
