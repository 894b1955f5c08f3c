"""What nobody recorded of an integral is no residual."""

import numpy as np
import pytest

from ffgym.diagnosis.measured import _without_trend


@pytest.mark.parametrize("slope", [False, True])
def test_means_and_slopes_of_rows_that_count_are_taken_off_and_nothing_else(slope):
    rng, time = np.random.default_rng(0), np.arange(60.0)
    valid = np.zeros((60, 2), dtype=bool)
    valid[5:55, 0], valid[10:30, 1] = True, True
    wave = rng.normal(size=(60, 2, 3))
    for m in range(2):
        own = valid[:, m]
        for k in range(3):
            wave[own, m, k] -= np.polyval(np.polyfit(time[own], wave[own, m, k], 1), time[own])
    drift = np.array([0.02, -0.5])[:, None] * (time[:, None, None] - 20.0) if slope else 0.0
    rest = _without_trend(wave + 3.0 + drift, valid, slope=slope)
    np.testing.assert_allclose(rest[valid], wave[valid], atol=1e-12)


def test_a_slope_stays_where_only_the_mean_is_unknown():
    rows = np.linspace(-1.0, 1.0, 41)[:, None, None]
    np.testing.assert_allclose(_without_trend(rows, np.ones((41, 1), dtype=bool), slope=False), rows, atol=1e-12)
