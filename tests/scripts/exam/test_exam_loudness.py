"""How loud a hidden effect is: what it adds to the residual, in energies of the noise."""

from types import SimpleNamespace

import numpy as np
import pytest

from ffgym.diagnosis.replay.springs import FlownAwayError
from scripts.exam.loudness import limit_effect, measure_noise_scale

ROW_DT = 0.02


@pytest.fixture
def noise():
    """Two motions of a channel with two components; the second motion is ten times as noisy."""
    rng = np.random.default_rng(0)
    rows = rng.normal(size=(400, 2, 2)) * np.array([1.0, 10.0])[:, None]
    rows[300:, 0] = 0.0  # the first motion is shorter
    return rows


@pytest.fixture
def valid(noise):
    return np.any(noise != 0, axis=2)


@pytest.fixture
def scale(noise, valid):
    return measure_noise_scale({"torque": noise}, valid, ROW_DT)


def test_as_much_as_the_noise_is_one(noise, scale):
    assert scale.energy({"torque": noise}) == pytest.approx(1.0)


def test_energy_grows_with_the_square_of_the_size(noise, scale):
    assert scale.energy({"torque": 2 * noise}) == pytest.approx(4.0)


def test_the_loudest_component_counts(noise, scale):
    assert scale.energy({"torque": noise * np.array([3.0, 0.0])}) == pytest.approx(9.0)


def test_what_a_quiet_motion_shows_is_not_drowned_by_a_noisy_one(noise, scale):
    heard = noise * np.array([10.0, 0.0])[:, None]
    assert scale.energy({"torque": heard}) == pytest.approx(100 * 300 / 700)


def test_what_calibration_may_be_wrong_by_is_not_heard_but_what_is_more_than_that_is(noise, valid):
    doubt = valid * np.sin(np.arange(400))[:, None]
    calibrated = measure_noise_scale({"torque": noise}, valid, ROW_DT, [{("torque", 0): doubt}])
    plain = measure_noise_scale({"torque": noise}, valid, ROW_DT)
    for size, left in ((2.0, 0.0), (14.0, 10.0)):  # four standard deviations are the most
        error = {"torque": np.stack([size * doubt, np.zeros_like(doubt)], axis=-1)}
        rest = {"torque": np.stack([left * doubt, np.zeros_like(doubt)], axis=-1)}
        assert calibrated.energy(error) == pytest.approx(plain.energy(rest), abs=1e-3)


class Deaf:
    """Hears effects up to some size, which is their energy; an arm would not hold larger ones."""

    def __init__(self, most):
        self.most = most

    def energy(self, size):
        if size > self.most:
            raise FlownAwayError(f"An arm does not stay where its motors are: {size}.")
        return size


def sized(size):
    return SimpleNamespace(effect=size, times=lambda factor: sized(factor * size))


@pytest.mark.parametrize(("most", "found"), [(5.0, 2.0), (1.5, 1.0), (0.3, 0.25)])
def test_an_effect_is_as_large_as_an_arm_holds_it(most, found):
    one, energy = limit_effect(Deaf(most), sized(2.0))
    assert (one.effect, energy) == (found, found)


def test_what_an_arm_never_holds_is_no_question():
    with pytest.raises(FlownAwayError, match="stay"):
        limit_effect(Deaf(0.0), sized(2.0))
