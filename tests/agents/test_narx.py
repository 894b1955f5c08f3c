"""The NARX network as a feed-forward law: on its own outputs, in a batch, from a file, and learned from trials."""

import numpy as np
import pytest

from ffgym.agents.declaration import AgentSetting
from ffgym.agents.law_files import load_law, save_law
from ffgym.agents.narx import NARX, learn_narx, samples_of
from ffgym.agents.supervised import MotorRecord
from ffgym.control import Window
from ffgym.core.errors import FFGymError
from ffgym.diagnosis.identification.narx import Errors, Regressors, Structure
from ffgym.simulation import Run
from ffgym.studies import sine_references
from tests.narx_samples import random_network

FORMS = {
    "(6.19)": Regressors(speed_lags=(0, 1), output_lags=()),
    "(6.20)": Regressors(),
    "slip": Regressors(slip_widths=(0.004, 0.016), output_lags=(1,)),
}


def law_of(regressors, n=2):
    return NARX(model=random_network(regressors, n=n, n_neurons=3))


def window_of(dq, dt=0.004):
    return Window(q=0 * dq, motor_dq=dq, motor_ddq=0 * dq, dt=dt)


@pytest.mark.parametrize("form", FORMS)
def test_rows_of_a_batch_do_not_touch_each_other(form):
    law = law_of(FORMS[form])
    window = window_of(np.random.default_rng(1).normal(size=(7, 2, 2)))
    together, memory = law.step(law.initial_memory(window), window)
    for row in range(7):
        torque, alone = law.step(law.initial_memory(window[row]), window[row])
        np.testing.assert_array_equal(together[row], torque)
        np.testing.assert_array_equal(memory[row], alone)


@pytest.mark.parametrize("form", FORMS)
def test_along_a_reference_the_law_is_its_network_in_free_run(form, one_axis):
    law, reference = law_of(FORMS[form], n=1), sine_references(one_axis)[1.0]
    simulated = law.model.simulate(reference.motor_dq)
    np.testing.assert_allclose(law.torque(reference), simulated, rtol=0, atol=1e-12)


@pytest.mark.parametrize("form", FORMS)
def test_a_file_gives_the_same_law_back(form, one_axis, tmp_path):
    law, reference = law_of(FORMS[form], n=1), sine_references(one_axis)[1.0]
    again = load_law(save_law(tmp_path / "narx.npz", law))
    assert again.model.regressors == law.model.regressors
    np.testing.assert_array_equal(again.torque(reference), law.torque(reference))


def test_a_law_is_refused_at_another_time_step_than_it_was_fitted_at():
    law, window = law_of(FORMS["(6.20)"]), window_of(np.zeros((2, 2)), dt=0.002)
    with pytest.raises(FFGymError, match=r"fitted to samples every 0.004 s; the reference has one every 0.002 s"):
        law.step(law.initial_memory(window), window)


def test_prediction_looks_better_than_simulation(one_axis):
    """Thesis 6.2.3, and the reason why a fit is judged by its simulation here."""
    setting, reference = AgentSetting.of(one_axis), sine_references(one_axis)[1.0]
    learned = learn_narx(setting.trial, [reference], np.random.default_rng(0), n_trials=1)
    (recording,) = setting.trial([Run(reference=reference)], 0)
    errors = Errors.of(learned.law.model, samples_of(MotorRecord.of(reference, recording)))
    assert errors.prediction.share[0] < 0.5 * errors.simulation.share[0]
    assert errors.simulation.share[0] < 0.5


def test_slip_elements_bring_the_simulation_near_to_the_prediction(one_axis):
    setting, reference = AgentSetting.of(one_axis), sine_references(one_axis)[1.0]
    structure = Structure(regressors=Regressors(slip_widths=(0.004, 0.008, 0.016), output_lags=()))
    learned = learn_narx(setting.trial, [reference], np.random.default_rng(0), structure, n_trials=1)
    (recording,) = setting.trial([Run(reference=reference)], 0)
    errors = Errors.of(learned.law.model, samples_of(MotorRecord.of(reference, recording)))
    assert errors.simulation.share[0] < 0.1
