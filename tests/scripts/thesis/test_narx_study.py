"""NARX networks on data of a LuGre model: the data are those of the thesis, and the study shows what it found."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.diagnosis.identification.narx import fit_linear
from ffgym.studies import lugre_samples, sine
from ffgym.studies.friction_data import SAMPLE_TIME
from scripts.thesis.narx import (
    BOTH,
    ESTIMATION,
    EXTENDED,
    LINEAR,
    PUBLISHED,
    VALIDATION,
    fit_narx,
    narx_records,
    reach_records,
    record_name,
    static_misfit,
)
from scripts.thesis.tables import spread


@pytest.fixture(scope="module")
def records(one_axis):
    return narx_records(one_axis.friction)


def test_the_data_are_the_discretised_lugre_model_of_the_thesis(one_axis):
    f_c, f_s, f_v, v_s, sigma_0, sigma_1 = 0.5367, 0.5634, 0.0437, 0.15, 69.9787, 0.6753  # (6.9) and (6.18)
    speed, z, torque = sine(1.0, 1.0, 0.2), 0.0, []
    for v in speed:  # (6.14)
        rate = v - sigma_0 * abs(v) / (f_c + (f_s - f_c) * np.exp(-((v / v_s) ** 2))) * z
        torque.append(sigma_0 * z + sigma_1 * rate + f_v * v)
        z += SAMPLE_TIME * rate
    np.testing.assert_allclose(lugre_samples(one_axis.friction, speed).torque[:, 0], torque, rtol=0, atol=1e-12)


def test_there_are_the_two_sines_of_the_thesis_and_its_fifteen_records(records):
    assert list(records) == [ESTIMATION, VALIDATION, *map(record_name, range(1, 16))]
    assert len(records[ESTIMATION].motor_dq) == 12001  # 6 s every 0.5 ms
    assert np.abs(records[record_name(11)].motor_dq).max() == pytest.approx(10.0, rel=1e-3)
    assert all(2000 <= samples.scored.sum() <= 2100 for samples in records.values())


def test_a_network_of_speeds_fits_one_sine_and_fails_on_another(records):
    """Thesis 6.2.3, Figure 6.10."""
    chosen = {name: records[name] for name in (ESTIMATION, VALIDATION)}
    fit = fit_narx(replace(PUBLISHED[0], n_evaluations=300), chosen, n_starts=2)
    assert np.all(fit.errors[ESTIMATION].simulation.fit > 90)
    assert np.all(fit.rms(VALIDATION) > 1.5 * fit.rms(ESTIMATION))


def test_a_network_of_its_own_output_predicts_far_better_than_it_runs(records):
    """Thesis 6.2.3, Figure 6.11."""
    chosen = {name: records[name] for name in (ESTIMATION, VALIDATION)}
    fit = fit_narx(replace(PUBLISHED[1], n_evaluations=200), chosen, n_starts=1)
    errors = fit.errors[VALIDATION]
    assert errors.prediction.fit[0] > 99
    assert errors.simulation.fit[0] < 90


def test_slip_elements_hold_on_records_that_were_not_fitted_to(one_axis, records):
    """Acceptance: an extension of the regressors that holds in free run."""
    [slip] = [candidate for candidate in EXTENDED if candidate.name == "slip_set_d"]
    fit = fit_narx(replace(slip, n_evaluations=150), records, n_starts=1)
    for name in (ESTIMATION, VALIDATION, *map(record_name, (1, 3, 5, 6, 8, 10, 11, 13, 15))):
        assert fit.rms(name) < 0.75 * static_misfit(one_axis.friction, records[name]).rms
        assert fit.errors[name].simulation.fit > 80


def test_a_linear_model_has_one_start_and_is_fitted_to_the_same_records(records):
    [candidate] = [each for each in LINEAR if each.name == "oe_both_set_d"]
    fit = fit_narx(candidate, records, n_starts=3)
    expected = fit_linear([records[record_name(n)] for n in (2, 4, 7, 9, 12, 14)], BOTH, focus="simulation")
    np.testing.assert_array_equal(fit.model.output_weights, expected.output_weights)
    assert fit.rms(VALIDATION).shape == (1,)


def test_linear_models_are_worse_than_the_static_curve_on_other_amplitudes(one_axis, records):
    """Thesis 3.1.2: a linear model is not rich enough."""
    fits = [fit_narx(each, records) for each in LINEAR if each.name in ("arx_both", "oe_both")]
    for name in map(record_name, (1, 3, 6, 8, 10, 11, 13, 15)):
        floor = static_misfit(one_axis.friction, records[name]).rms
        assert all(fit.rms(name) > floor for fit in fits), name


def test_the_start_that_is_drawn_is_the_median_one(records):
    chosen = {name: records[name] for name in (ESTIMATION, VALIDATION)}
    fit = fit_narx(replace(PUBLISHED[0], n_evaluations=20), chosen, n_starts=3)
    assert fit.rms(VALIDATION)[fit.typical] == np.median(fit.rms(VALIDATION))


def test_fits_are_the_same_for_the_same_seed_only(records):
    chosen = {name: records[name] for name in (ESTIMATION, VALIDATION)}
    candidate = replace(PUBLISHED[0], n_evaluations=20)
    one, again, other = (fit_narx(candidate, chosen, n_starts=1, seed=seed).model.biases for seed in (0, 0, 1))
    np.testing.assert_array_equal(one, again)
    assert np.any(one != other)


def test_friction_of_several_motors_and_times_that_are_none_are_refused(irb4600):
    with pytest.raises(FFGymError, match="friction has 6 joints, must be that of one motor"):
        lugre_samples(irb4600.friction, sine(1.0, 1.0, 0.1))
    with pytest.raises(FFGymError, match=r"duration = -1.0 s is out of range"):
        sine(1.0, 1.0, -1.0)


def test_motions_beyond_table_6_1_are_faster_slower_and_mixed(one_axis):
    peaks = [np.abs(samples.motor_dq).max() for samples in reach_records(one_axis.friction).values()]
    assert max(peaks) > 10
    assert min(peaks) < 0.1


@pytest.mark.parametrize(
    ("fits", "written"),
    [
        ((99.94,), "99.9"),
        ((98.96,), "99"),
        ((66.8, -0.04, 99.4), "67 (0 to 99.4)"),
        ((-99.6, -668.3, -23.5), "-100 (-670 to -24)"),
        ((-2101.8, -10064.2, 66.9), "-2100 (-10000 to 67)"),
        ((-2124.4, -10118.1, 66.8), "-2100 (-10000 to 67)"),
    ],
)
def test_fits_are_written_by_the_digits_that_another_processor_finds(fits, written):
    assert spread(np.array(fits)) == written
