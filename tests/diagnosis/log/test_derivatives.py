"""Speeds and accelerations of sampled angles."""

import numpy as np
import pytest

from ffgym.diagnosis.sampling import derivatives, derivatives_of_motions

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
    first, second = derivatives(np.stack([angle, -2 * angle], axis=1), DT)
    for found, true in ((first, speed), (second, acceleration)):
        np.testing.assert_allclose(found, np.stack([true, -2 * true], axis=1), atol=1e-5 * np.abs(true).max())


def test_motions_side_by_side_are_differentiated_one_by_one_and_rest_where_they_are_padded():
    long, short = swing(3.0)[0], swing(7.0, n=1500)[0]
    side_by_side = np.stack([long, np.pad(short, (0, 501), mode="edge")], axis=1)
    first, second = derivatives_of_motions(side_by_side[..., None], [2001, 1500], DT)
    for motion, angle in enumerate((long, short)):
        alone = derivatives(angle[:, None], DT)
        np.testing.assert_allclose(first[: len(angle), motion], alone[0], atol=1e-12)
        np.testing.assert_allclose(second[: len(angle), motion], alone[1], atol=1e-9)
    assert not first[1500:, 1].any()
    assert not second[1500:, 1].any()
