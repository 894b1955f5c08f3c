"""How loud a hidden effect is: what it adds to the residual, in energies of the noise."""

import numpy as np
import pytest

from ffgym.exam.loudness import added_energy


@pytest.fixture
def noise():
    """Two motions of a channel with two components; the second motion is ten times as noisy."""
    rng = np.random.default_rng(0)
    rows = rng.normal(size=(400, 2, 2)) * np.array([1.0, 10.0])[:, None]
    rows[300:, 0] = 0.0  # the first motion is shorter
    return {"torque": rows}


def test_as_much_as_the_noise_is_one(noise):
    without = {"torque": np.zeros_like(noise["torque"])}
    assert added_energy(noise, without, noise) == pytest.approx(1.0)


def test_energy_grows_with_the_square_of_the_size(noise):
    without = {"torque": np.ones_like(noise["torque"])}
    double = {"torque": 1 + 2 * noise["torque"]}
    assert added_energy(double, without, noise) == pytest.approx(4.0)


def test_the_loudest_component_counts(noise):
    without = {"torque": np.zeros_like(noise["torque"])}
    one = noise["torque"] * np.array([3.0, 0.0])
    assert added_energy({"torque": one}, without, noise) == pytest.approx(9.0)


def test_what_a_quiet_motion_shows_is_not_drowned_by_a_noisy_one(noise):
    without = {"torque": np.zeros_like(noise["torque"])}
    heard = noise["torque"] * np.array([10.0, 0.0])[:, None]
    assert added_energy({"torque": heard}, without, noise) == pytest.approx(100 * 300 / 700)


def test_a_channel_that_the_log_lacks_does_not_count(noise):
    without = {"torque": np.zeros_like(noise["torque"])}
    assert added_energy({"torque": noise["torque"]}, without, noise | {"tool": noise["torque"]}) == pytest.approx(1.0)
