"""Random multisines: smooth, at rest at both ends, as fast as asked for."""

import hypothesis
import numpy as np
import pytest
from hypothesis import strategies as st

from ffgym.core.errors import FFGymError
from ffgym.paths import random_multisine
from ffgym.paths.excitations import FREQUENCIES

CENTRE, PEAK = np.array([0.3, -1.0, 2.0]), np.array([0.1, 1.0, 5.0])


def path(seed=0, duration=3.0, **kwargs):
    return random_multisine(np.random.default_rng(seed), CENTRE, PEAK, duration, **kwargs)


@hypothesis.given(seed=st.integers(0, 2**32), n_sines=st.integers(1, 8))
@hypothesis.settings(max_examples=25)
def test_speed_and_acceleration_are_derivatives_of_the_position(seed, n_sines):
    fine = path(seed, n_sines=n_sines, dt=1e-4)
    for values, rate in ((fine.q, fine.dq), (fine.dq, fine.ddq)):
        central = (values[2:] - values[:-2]) / 2e-4
        size = np.abs(rate).max(axis=0)
        np.testing.assert_allclose(central / size, rate[1:-1] / size, atol=2e-3)


@hypothesis.given(seed=st.integers(0, 2**32), duration=st.floats(1.1, 5.0))
@hypothesis.settings(max_examples=25)
def test_the_largest_speed_of_each_joint_is_the_peak_speed(seed, duration):
    motion = path(seed, duration)
    np.testing.assert_allclose(np.abs(motion.dq).max(axis=0), PEAK, rtol=0.05)
    assert (np.abs(path(seed, duration, dt=2e-4).dq).max(axis=0) < 1.05 * PEAK).all()


def test_the_largest_sample_is_the_peak_speed_exactly():
    for seed in range(10):
        np.testing.assert_allclose(np.abs(path(seed).dq).max(axis=0), PEAK, rtol=1e-9)


def test_it_rests_at_its_centre_before_and_after():
    motion = path(dwell=0.2)
    resting = (motion.t <= 0.2) | (motion.t >= 2.8 - 1e-9)
    np.testing.assert_allclose(motion.q[resting] - CENTRE, 0.0, atol=1e-12)
    np.testing.assert_allclose(motion.dq[resting], 0.0, atol=1e-12)
    np.testing.assert_allclose(motion.ddq[resting], 0.0, atol=1e-9)
    assert (np.abs(motion.dq[(motion.t > 0.3) & (motion.t < 2.7)]).max(axis=0) > 0).all()
    assert [phase.kind for phase in motion.phases] == ["standstill", "motion", "standstill"]
    assert motion.phases[-1].end == pytest.approx(3.0)


def test_the_fade_reaches_one_between_its_ramps():
    one = random_multisine(np.random.default_rng(2), np.zeros(1), np.ones(1), 4.0, n_sines=1, ramp=0.5, dt=1e-3)
    inside = (one.t > 0.65) & (one.t < 3.35)
    # a pure sine: its acceleration is -omega^2 times its position
    ratio = -one.ddq[inside, 0] @ one.q[inside, 0] / (one.q[inside, 0] @ one.q[inside, 0])
    omega = np.sqrt(ratio)
    np.testing.assert_allclose(one.ddq[inside, 0], -(omega**2) * one.q[inside, 0], atol=1e-9 * omega**2)
    assert FREQUENCIES[0] <= omega / 2 / np.pi <= FREQUENCIES[1]


def test_frequencies_are_spread_evenly_in_their_logarithm():
    drawn = []
    for seed in range(300):
        one = random_multisine(np.random.default_rng(seed), np.zeros(1), np.ones(1), 2.0, n_sines=1, dt=0.01)
        inside = (one.t > 0.6) & (one.t < 1.4)
        q, ddq = one.q[inside, 0], one.ddq[inside, 0]
        drawn.append(np.sqrt(-(ddq @ q) / (q @ q)) / 2 / np.pi)
    low, high = np.log(FREQUENCIES)
    share = (np.log(drawn) - low) / (high - low)
    assert share.min() >= -1e-6
    assert share.max() <= 1 + 1e-6
    np.testing.assert_allclose(np.quantile(share, [0.25, 0.5, 0.75]), [0.25, 0.5, 0.75], atol=0.1)


def test_joints_move_independently_and_a_seed_repeats_the_motion():
    np.testing.assert_array_equal(path(4).q, path(4).q)
    assert not np.allclose(path(4).q, path(5).q)
    shape = path(4).dq / PEAK
    assert np.abs(np.corrcoef(shape.T) - np.eye(3)).max() < 0.8


def test_a_joint_without_speed_stands_still_and_the_others_move_as_they_would():
    still = random_multisine(np.random.default_rng(0), CENTRE, PEAK * [1, 0, 1], 3.0)
    np.testing.assert_array_equal(still.q[:, 1], CENTRE[1])
    np.testing.assert_array_equal(still.q[:, [0, 2]], path(0).q[:, [0, 2]])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"duration": 0.9}, "duration = 0.9 s must be at least two ramps and two rests, 1 s"),
        ({"duration": np.nan}, "duration must be finite"),
        ({"centre": [[0.0]]}, r"centre has shape \(1, 1\)"),
        ({"peak_speed": [1.0]}, r"peak_speed has shape \(1,\), must be \(3\)"),
        ({"peak_speed": [1.0, -1.0, 1.0]}, "peak_speed = .* must be >= 0 on every joint"),
        ({"n_sines": 0}, "n_sines = 0"),
        ({"ramp": 0.0}, "ramp = 0.0 s"),
        ({"dwell": 0.0}, "dwell = 0.0 s"),
        ({"dt": 0.0}, "dt = 0.0 s"),
        ({"dt": 0.5}, "dt = 0.5 s is out of range, must be in .0.0, 0.4"),
        ({"duration": 1e12}, "duration = 1000000000000.0 s must be at most 1e.07 steps"),
        ({"centre": [], "peak_speed": []}, "centre is empty"),
    ],
)
def test_what_cannot_be_moved_is_refused(arguments, message):
    given = {"centre": CENTRE, "peak_speed": PEAK, "duration": 3.0} | arguments
    with pytest.raises(FFGymError, match=message):
        random_multisine(np.random.default_rng(0), **given)
