"""Rows of signals: the same low-pass without delay for all, from finitely many samples."""

import numpy as np
import pytest

from ffgym.diagnosis.sampling import CUTOFF, Sampling


@pytest.fixture(scope="module")
def sampling():
    return Sampling(dt=0.001, n_samples=1000, cutoff=CUTOFF)


def wave(sampling, frequency):
    return np.sin(2 * np.pi * frequency * sampling.dt * np.arange(sampling.n_samples))


@pytest.mark.parametrize(("frequency", "passes"), [(2.0, True), (10.0, True), (90.0, False), (200.0, False)])
def test_slow_signals_pass_without_delay_and_fast_ones_do_not(sampling, frequency, passes):
    values = wave(sampling, frequency)
    inside = sampling.valid(np.ones((len(values), 1), dtype=bool))[:, 0]
    rest = sampling(values)[inside] - (values[sampling.at][inside] if passes else 0.0)
    assert np.abs(rest).max() < 0.01


def test_a_row_is_symmetric_and_depends_on_samples_of_its_reach_alone(sampling):
    weights = sampling.operator.toarray()
    middle = len(sampling.at) // 2
    at, half = sampling.at[middle], sampling.half_length
    reach = slice(at - half, at + half + 1)
    np.testing.assert_allclose(weights[middle, reach], weights[middle, reach][::-1], atol=1e-15)
    np.testing.assert_allclose(weights[middle, reach].sum(), 1.0)
    assert not np.delete(weights[middle], np.arange(at - half, at + half + 1)).any()


def test_rows_are_valid_where_they_depend_on_known_samples_alone(sampling):
    known = np.ones((sampling.n_samples, 1), dtype=bool)
    known[500] = False
    expected = [
        at >= sampling.half_length
        and at + sampling.half_length < sampling.n_samples
        and abs(at - 500) > sampling.half_length
        for at in sampling.at
    ]
    np.testing.assert_array_equal(sampling.valid(known)[:, 0], expected)


def test_coarser_samples_have_the_same_rows(sampling):
    every = 2
    assert sampling.stride % every == 0
    coarse = sampling.coarser(every)
    np.testing.assert_allclose(coarse.at * coarse.dt, sampling.at * sampling.dt)
    values = wave(sampling, 5.0)
    inside = sampling.valid(np.ones((len(values), 1), dtype=bool))[:, 0]
    np.testing.assert_allclose(coarse(values[::every])[inside], sampling(values)[inside], atol=1e-3)


@pytest.mark.parametrize("dt", [0.0005, 0.001, 0.002, 0.004, 0.01])
def test_the_cut_off_is_low_enough_for_the_sample_rate_and_rows_are_fast_enough_for_it(dt):
    sampling = Sampling.of(dt, [round(100 / dt)])
    assert sampling.cutoff == min(CUTOFF, 0.2 / dt)
    assert sampling.row_dt < 0.5 / sampling.cutoff


def test_a_short_log_is_compared_in_a_wider_band_that_its_samples_still_know():
    long, short, slow = (Sampling.of(0.004, [n]) for n in (20000, 2500, 100))
    assert long.cutoff == 40.0
    assert short.cutoff == slow.cutoff == 0.38 / short.dt
    assert short.cutoff <= short.motion_filter.cutoff < 0.5 / short.dt
    assert Sampling.of(0.004, [2500, 2500]).cutoff == 50.0


def test_signals_of_several_columns_are_filtered_one_by_one(sampling):
    values = np.stack([wave(sampling, f) for f in (1.0, 3.0, 7.0, 50.0)], axis=1).reshape(-1, 2, 2)
    np.testing.assert_allclose(sampling(values)[:, 1, 0], sampling(values[:, 1, 0]), atol=1e-14)
