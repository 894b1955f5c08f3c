"""Samples as they are compared: derivatives, white noise, one low-pass."""

import numpy as np
import pytest

from ffgym.diagnosis.sampling import Sampling, estimate_noise_above_band, without_trembling
from ffgym.diagnosis.settings import settings
from ffgym.logs.preparation import LowPass, differentiate, differentiate_motions


@pytest.fixture(scope="module")
def sampling():
    return Sampling(dt=0.001, n_samples=1000, cutoff=settings().sampling.cutoff)


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
    assert sampling.cutoff == min(settings().sampling.cutoff, 0.2 / dt)
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


DT = 0.004


def swing(frequency, n=2001):
    """A swing between rests on the way from one place to another: angle, speed, acceleration."""
    t = DT * np.arange(n)
    turn, w = np.pi / t[-1], 2 * np.pi * frequency
    slow, slow_rate, slow_change = (
        np.sin(turn * t) ** 2,
        turn * np.sin(2 * turn * t),
        2 * turn**2 * np.cos(2 * turn * t),
    )
    fast, fast_rate = np.sin(w * t), w * np.cos(w * t)
    angle = slow * fast + 0.3 * t + 1.0
    speed = slow_rate * fast + slow * fast_rate + 0.3
    return angle, speed, slow_change * fast + 2 * slow_rate * fast_rate - slow * w**2 * fast


@pytest.mark.parametrize("frequency", [0.5, 10.0, 40.0, 100.0])
def test_derivatives_are_right_up_to_half_the_sample_rate(frequency):
    angle, speed, acceleration = swing(frequency)
    first, second = differentiate(np.stack([angle, -2 * angle], axis=1), DT)
    for found, true in ((first, speed), (second, acceleration)):
        np.testing.assert_allclose(found, np.stack([true, -2 * true], axis=1), atol=1e-5 * np.abs(true).max())


def test_motions_side_by_side_are_differentiated_one_by_one_and_rest_where_they_are_padded():
    long, short = swing(3.0)[0], swing(7.0, n=1500)[0]
    side_by_side = np.stack([long, np.pad(short, (0, 501), mode="edge")], axis=1)
    first, second = differentiate_motions(side_by_side[..., None], [2001, 1500], DT)
    for motion, angle in enumerate((long, short)):
        alone = differentiate(angle[:, None], DT)
        np.testing.assert_allclose(first[: len(angle), motion], alone[0], atol=1e-12)
        np.testing.assert_allclose(second[: len(angle), motion], alone[1], atol=1e-9)
    assert not first[1500:, 1].any()
    assert not second[1500:, 1].any()


NOISE_DT = 0.001
LOW_PASS = LowPass(cutoff=100.0)


@pytest.mark.parametrize("deviation", [1e-6, 1e-3, 2.0])
def test_the_noise_of_a_signal_is_found_beneath_its_motion(deviation):
    rng = np.random.default_rng(0)
    t = NOISE_DT * np.arange(8000)
    motion = np.stack([100 * np.sin(2 * np.pi * 1.3 * t), 3 * np.cos(2 * np.pi * 7.0 * t)], axis=1)
    values = motion * min(deviation, 1.0) * 1e3 + rng.normal(scale=deviation, size=motion.shape)
    np.testing.assert_allclose(estimate_noise_above_band(values, LOW_PASS, NOISE_DT), deviation, rtol=0.05)


@pytest.mark.parametrize(("dt", "cutoff"), [(0.001, 100.0), (0.002, 100.0), (0.005, 50.0), (0.01, 38.0)])
def test_white_noise_is_found_whatever_part_of_the_band_shows_it(dt, cutoff):
    values = np.random.default_rng(2).normal(size=(round(4.0 / dt), 200))
    found = estimate_noise_above_band(values, LowPass(cutoff=cutoff), dt)
    assert np.sqrt(np.mean(found**2)) == pytest.approx(1.0, abs=0.08)


def test_reversals_that_come_every_second_are_no_noise_of_rare_samples():
    """Friction of 1 N m that turns with the speed, and noise of 0.005 N m every 10 ms: most blocks are quiet."""
    t = 0.01 * np.arange(2400)
    friction = np.tanh(50 * np.sin(np.pi * t))
    values = friction + np.random.default_rng(3).normal(scale=0.005, size=t.size)
    assert estimate_noise_above_band(values[:, None], LowPass(cutoff=38.0), 0.01)[0] == pytest.approx(0.005, rel=0.3)


def test_some_peaks_are_no_noise():
    rng = np.random.default_rng(1)
    values = rng.normal(size=(8000, 1))
    values[::400] += 100.0
    assert estimate_noise_above_band(values, LOW_PASS, NOISE_DT)[0] < 2.5


def test_what_a_machine_does_above_its_band_in_fast_motion_is_no_noise():
    rng = np.random.default_rng(4)
    t = NOISE_DT * np.arange(8000)
    slow = np.sin(np.pi * t)
    ripple = 0.5 * np.clip(slow, 0.0, None) ** 2 * np.sin(2 * np.pi * 180.0 * t)
    values = slow + ripple + rng.normal(scale=0.01, size=8000)
    np.testing.assert_allclose(estimate_noise_above_band(values[:, None], LOW_PASS, NOISE_DT), 0.01, rtol=0.1)


def test_a_reading_in_steps_has_the_noise_of_where_it_moves():
    t = NOISE_DT * np.arange(8000)
    angle = np.where(t < 5.0, 0.3, 0.3 + 2.0 * (t - 5.0))
    read = np.round(angle[:, None] / 0.013) * 0.013
    np.testing.assert_allclose(estimate_noise_above_band(read, LOW_PASS, NOISE_DT), 0.013 / np.sqrt(12), rtol=0.2)


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
