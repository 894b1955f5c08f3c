"""Size of errors without the noise of their sensor."""

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.recordings.metrics import rms_without_noise


def make_errors(size: float, noise: float, seed: int = 0, period: int = 200) -> np.ndarray:
    """Errors (4000, 3) of an RMS length, a sine in two directions, with white noise on each coordinate."""
    phase = 2 * np.pi * np.arange(4000) / period
    errors = size * np.stack([np.sin(phase), np.cos(phase), 0 * phase], axis=1)
    return errors + noise * np.random.default_rng(seed).standard_normal(errors.shape)


@pytest.mark.parametrize("period", [20, 50, 1000])
def test_without_noise_it_is_the_plain_root_mean_square(period):
    quiet = rms_without_noise(make_errors(2.0, 0.0, period=period), np.ones(4000, dtype=bool))
    assert quiet.rms == pytest.approx(2.0, rel=2e-3)
    assert quiet.doubt < 2e-3


def test_noise_larger_than_the_error_is_taken_off_and_the_doubt_says_what_it_leaves():
    found = [rms_without_noise(make_errors(1.0, 2.0, seed), np.ones(4000, dtype=bool)) for seed in range(100)]
    sizes = np.array([one.rms for one in found])
    assert np.mean(sizes**2) == pytest.approx(1.0, abs=0.05)
    assert np.std(sizes) == pytest.approx(np.mean([one.doubt for one in found]), rel=0.3)


def test_errors_that_noise_hides_are_as_large_as_noise_can_hide_and_in_doubt():
    for seed in range(20):
        hidden = rms_without_noise(make_errors(0.0, 1.0, seed), np.ones(4000, dtype=bool))
        assert 0.05 < hidden.rms < 0.5
        assert hidden.doubt > 0.1


def test_only_rows_that_count_with_their_neighbours_enter():
    errors, counts = make_errors(1.0, 0.0), np.zeros(4000, dtype=bool)
    counts[1000:3000] = True
    errors[~counts] = np.nan
    assert rms_without_noise(errors, counts).rms == pytest.approx(1.0, rel=1e-3)
    with pytest.raises(FFGymError, match="too few"):
        rms_without_noise(errors, np.arange(4000) % 3 == 0)
