"""The NARX network: its recursion, memory and bound, sample by sample and along whole motions."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from narx_forms import FORMS

from ffgym.core.errors import FFGymError
from ffgym.diagnosis.identification.narx.model import joint_models, sigmoid
from ffgym.robot.friction import slip_along


def test_the_sigmoid_is_the_one_of_the_thesis_and_does_not_overflow():
    x = np.linspace(-30, 30, 61)
    np.testing.assert_allclose(sigmoid(x), 1 / (1 + np.exp(-x)), rtol=0, atol=1e-15)
    assert sigmoid(np.array([-1e6, 1e6])).tolist() == [0, 1]


@pytest.mark.parametrize("form", FORMS)
def test_simulation_is_the_recursion_written_out(form, network, sweep):
    model, v, regressors = network(FORMS[form]), sweep(rows=40), FORMS[form]
    slip = slip_along(v, model.dt, np.array(regressors.slip_widths))
    y, u = np.zeros((40, 2)), v / model.speed_scale
    for k in range(1, 40):
        for j in range(2):
            past = [u[max(k - lag, 0), j] for lag in regressors.speed_lags]
            past += list(slip[k, j])
            past += [y[k - lag, j] if k >= lag else 0.0 for lag in regressors.output_lags]
            inside = model.input_weights[j] @ past + model.biases[j]
            y[k, j] = model.offset[j] + model.output_weights[j] @ (1 / (1 + np.exp(-inside)))
    np.testing.assert_allclose(model.simulate(v), model.torque_scale * y, rtol=0, atol=1e-12)


@pytest.mark.parametrize("form", FORMS)
def test_step_by_step_gives_what_a_simulation_along_the_whole_motion_gives(form, network, sweep):
    model, v = network(FORMS[form]), sweep(rows=60)
    memory, torque = model.hold_memory(v[0]), np.zeros_like(v)
    for k in range(1, 60):
        torque[k], memory = model.advance(memory, v[k])
    np.testing.assert_allclose(torque, model.simulate(v), rtol=0, atol=1e-12)


@pytest.mark.parametrize("form", FORMS)
def test_predicting_from_its_own_simulation_is_the_simulation(form, network, sweep):
    model, v = network(FORMS[form]), sweep()
    torque = model.simulate(v)
    np.testing.assert_allclose(model.predict(v, torque)[1:], torque[1:], rtol=0, atol=1e-12)


@given(st.sampled_from(sorted(FORMS)), st.integers(0, 1000), st.floats(0, 1e3))
@settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_torque_stays_bounded_whatever_the_weights_and_the_motion(network, form, seed, size):
    model = network(FORMS[form], seed)
    v = size * np.random.default_rng(seed).normal(size=(100, 2))
    assert np.all(np.abs(model.simulate(v)) <= model.bound + 1e-12)


def test_past_outputs_and_slip_elements_remember_and_past_speeds_do_not(network, sweep):
    v = sweep(rows=100)
    other = v.copy()
    other[:50] *= -1
    for form, remembers in (("(6.19)", False), ("(6.20)", True), ("slip", True)):
        model = network(FORMS[form], size=1.0)
        apart = np.abs(model.simulate(v) - model.simulate(other))[52:]
        assert (apart.max() > 1e-9) == remembers


def test_slip_elements_forget_once_they_have_slipped(network, sweep):
    model, v = network(FORMS["slip"]), sweep(rows=300)
    other = v.copy()
    other[:50] *= -1
    apart = np.abs(model.simulate(v) - model.simulate(other))
    assert apart[52].max() > 1e-6
    assert apart[200:].max() < 1e-9


def test_motors_are_put_together_from_several_networks(network, sweep):
    models, v = [network(seed=seed) for seed in (1, 2)], sweep(rows=50)
    mixed = joint_models(models, np.array([1, 0])).simulate(v)
    np.testing.assert_array_equal(mixed[:, 0], models[1].simulate(v)[:, 0])
    np.testing.assert_array_equal(mixed[:, 1], models[0].simulate(v)[:, 1])


@pytest.mark.parametrize("form", FORMS)
def test_motions_of_other_motors_are_refused(form, network, sweep):
    model, v = network(FORMS[form]), sweep()
    with pytest.raises(FFGymError, match=r"motor_dq has shape \(600, 1\), must be \(any, 2\)"):
        model.simulate(v[:, :1])
    with pytest.raises(FFGymError, match="motor_dq has no samples; give the friction model a motion"):
        model.simulate(v[:0])
    with pytest.raises(FFGymError, match=r"torque has shape \(10, 2\), must be \(600, 2\)"):
        model.predict(v, v[:10])


def test_what_makes_no_network_is_refused(network):
    model = network()
    with pytest.raises(FFGymError, match="input_weights has shape"):
        replace(model, regressors=FORMS["long"])
    with pytest.raises(FFGymError, match=r"speed_scale = .* must be > 0"):
        replace(model, speed_scale=np.zeros(2))
    with pytest.raises(FFGymError, match=r"dt = 0.0 s"):
        replace(model, dt=0.0)
