"""Rows that stand out from a misfit that is everywhere count less; those that stand out from noise count fully."""

import numpy as np
import pytest

from ffgym.diagnosis.settings import settings
from ffgym.diagnosis.weights import bound_outliers

KEY = ("torque", 0)
NOISE = 0.02


def bounded(misfit, outlier, weight=None):
    """Weights of 2000 rows with a misfit in noise's deviations, of which every hundredth is an outlier."""
    rows = misfit * NOISE * np.random.default_rng(0).normal(size=(1000, 2))
    rows[::100] = outlier * NOISE
    weight = np.full(rows.shape, 1 / NOISE) if weight is None else weight
    return rows, weight, bound_outliers({KEY: weight}, {"torque": rows[..., None]})[KEY]


@pytest.mark.parametrize("misfit", [1.0, 0.8 * settings().noise.misfit_everywhere])
def test_where_noise_is_the_yardstick_what_stands_out_is_what_is_looked_for(misfit):
    _, weight, found = bounded(misfit, 1000.0)
    np.testing.assert_array_equal(found, weight)


def test_where_a_model_misses_everywhere_no_row_counts_more_than_a_few_usual_ones():
    misfit = 10 * settings().noise.misfit_everywhere
    rows, weight, found = bounded(misfit, 100 * misfit)
    assert np.abs(found * rows).max() == pytest.approx(settings().noise.outlier * misfit, rel=0.1)
    usual = np.abs(rows) < 2.5 * misfit * NOISE
    np.testing.assert_array_equal(found[usual], weight[usual])
    assert np.mean(found < weight) < 0.02


def test_rows_that_do_not_count_neither_count_nor_say_what_is_usual():
    weight = np.full((1000, 2), 1 / NOISE)
    weight[1::2] = 0.0
    rows, _, found = bounded(10 * settings().noise.misfit_everywhere, 1e4, weight)
    np.testing.assert_array_equal(found[1::2], 0.0)
    louder = rows.copy()
    louder[1::2] *= 1e6
    again = bound_outliers({KEY: weight}, {"torque": louder[..., None]})[KEY]
    np.testing.assert_array_equal(again, found)


def test_a_component_without_rows_stays_without():
    nothing = np.zeros((10, 1))
    np.testing.assert_array_equal(bound_outliers({KEY: nothing}, {"torque": np.ones((10, 1, 1))})[KEY], nothing)
