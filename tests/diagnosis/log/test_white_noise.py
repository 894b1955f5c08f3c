"""Noise of readings, and readings of motors that stand."""

import numpy as np
import pytest

from ffgym.diagnosis.identification import LowPass
from ffgym.diagnosis.sampling import white_noise, without_trembling

DT = 0.001
LOW_PASS = LowPass(cutoff=100.0)


@pytest.mark.parametrize("deviation", [1e-6, 1e-3, 2.0])
def test_the_noise_of_a_signal_is_found_beneath_its_motion(deviation):
    rng = np.random.default_rng(0)
    t = DT * np.arange(8000)
    motion = np.stack([100 * np.sin(2 * np.pi * 1.3 * t), 3 * np.cos(2 * np.pi * 7.0 * t)], axis=1)
    values = motion * min(deviation, 1.0) * 1e3 + rng.normal(scale=deviation, size=motion.shape)
    np.testing.assert_allclose(white_noise(values, LOW_PASS, DT), deviation, rtol=0.05)


@pytest.mark.parametrize(("dt", "cutoff"), [(0.001, 100.0), (0.002, 100.0), (0.005, 50.0), (0.01, 38.0)])
def test_white_noise_is_found_whatever_part_of_the_band_shows_it(dt, cutoff):
    values = np.random.default_rng(2).normal(size=(round(4.0 / dt), 200))
    found = white_noise(values, LowPass(cutoff=cutoff), dt)
    assert np.sqrt(np.mean(found**2)) == pytest.approx(1.0, abs=0.08)


def test_reversals_that_come_every_second_are_no_noise_of_rare_samples():
    """Friction of 1 N m that turns with the speed, and noise of 0.005 N m every 10 ms: most blocks are quiet."""
    t = 0.01 * np.arange(2400)
    friction = np.tanh(50 * np.sin(np.pi * t))
    values = friction + np.random.default_rng(3).normal(scale=0.005, size=t.size)
    assert white_noise(values[:, None], LowPass(cutoff=38.0), 0.01)[0] == pytest.approx(0.005, rel=0.3)


def test_some_peaks_are_no_noise():
    rng = np.random.default_rng(1)
    values = rng.normal(size=(8000, 1))
    values[::400] += 100.0
    assert white_noise(values, LOW_PASS, DT)[0] < 2.5


def test_what_a_machine_does_above_its_band_in_fast_motion_is_no_noise():
    rng = np.random.default_rng(4)
    t = DT * np.arange(8000)
    slow = np.sin(np.pi * t)
    ripple = 0.5 * np.clip(slow, 0.0, None) ** 2 * np.sin(2 * np.pi * 180.0 * t)
    values = slow + ripple + rng.normal(scale=0.01, size=8000)
    np.testing.assert_allclose(white_noise(values[:, None], LOW_PASS, DT), 0.01, rtol=0.1)


def test_a_reading_in_steps_has_the_noise_of_where_it_moves():
    t = DT * np.arange(8000)
    angle = np.where(t < 5.0, 0.3, 0.3 + 2.0 * (t - 5.0))
    read = np.round(angle[:, None] / 0.013) * 0.013
    np.testing.assert_allclose(white_noise(read, LOW_PASS, DT), 0.013 / np.sqrt(12), rtol=0.2)


def test_a_motor_that_stands_is_read_as_standing():
    rng = np.random.default_rng(2)
    angle = 0.3 + rng.uniform(-1.0, 1.0, size=(500, 2)) * [1e-4, 2e-4]
    followed = without_trembling(angle, np.array([2e-4, 4e-4]))
    np.testing.assert_array_equal(followed, np.broadcast_to(angle[0], followed.shape))


def test_a_motor_that_moves_is_followed_within_the_band_and_at_its_speed():
    angle = np.linspace(0.0, 1.0, 1001)[:, None]
    followed = without_trembling(angle, np.array([0.01]))
    assert np.abs(followed - angle).max() <= 0.01 + 1e-12
    np.testing.assert_allclose(np.diff(followed[20:], axis=0), np.diff(angle[20:], axis=0), rtol=1e-9)


def test_exact_readings_stay_as_they_are():
    angle = np.random.default_rng(3).normal(size=(50, 2))
    np.testing.assert_array_equal(without_trembling(angle, np.zeros(2)), angle)
