"""Noise that is not white is told from what a model lacks by how it goes on above the band that is compared."""

import numpy as np
import pytest

from ffgym.diagnosis import diagnose
from ffgym.diagnosis.noise_spectrum import estimate_noise_spectrum
from ffgym.effects import EFFECTS
from ffgym.logs.preparation import LowPass
from ffgym.simulation.plant import Machine
from tests.diagnosis.continuous_axis import recorded, red_noise, sines

DT, CUTOFF, LOW_PASS = 0.001, 40.0, LowPass(cutoff=100.0)
STAYS = 0.9


def noise(stays, white=0.0, seed=1):
    """Six parts of eight seconds of two components."""
    rng = np.random.default_rng(seed)
    n = 8000
    return [
        np.stack([red_noise(1.0, stays, n, rng) + white * rng.normal(size=n) for _ in range(2)], axis=1)
        for _ in range(6)
    ]


def colour(signal, left=None):
    """Of signals, of which a model leaves all, and of itself what white noise is."""
    white = [np.full_like(part, 1e-3) * np.random.default_rng(3).normal(size=part.shape) for part in signal]
    return estimate_noise_spectrum(signal, left or signal, white, CUTOFF, LOW_PASS, DT)


def test_white_noise_has_no_colour():
    for seed in range(10):
        assert colour(noise(0.0, seed=seed)).is_white


@pytest.mark.parametrize("white", [0.0, 0.2])
def test_how_much_noise_falls_and_from_which_frequency_on_is_found(white):
    found, given = colour(noise(STAYS, white)), noise(STAYS, white)
    drawn = [found.drawn(j, 80_000, np.random.default_rng(2)) for j in range(2)]
    for j in range(2):
        expected = np.concatenate([LOW_PASS(part[:, j], DT) for part in given])
        assert LOW_PASS(drawn[j], DT).std() == pytest.approx(expected.std(), rel=0.2)
        assert found.beside(np.ones((1, 2)))[0, j] == pytest.approx(white, abs=0.15)


def test_what_lies_in_the_band_alone_is_none():
    """A model that is wrong, with white noise."""
    slow = [part + LowPass(cutoff=10.0)(20 * part, DT) for part in noise(0.0)]
    assert colour(slow).is_white


def test_steps_between_which_nothing_is_heard_are_no_noise_however_often_they_come():
    """Forces that are switched fall with the frequency as coloured noise does, but are quiet most of the time."""
    steps = np.roll(np.repeat(np.tile([0.0, 5.0], 8), 500), 250)[:, None]
    quiet = [0.01 * part[:, :1] for part in noise(0.0)]
    assert colour([steps + part for part in quiet]).is_white


RARE = 0.008
"""Sample period of which no band is left in which noise could be seen to fall [s]."""


def rare(stays, seed=1):
    """Twelve parts of four seconds of three components, what of them is found, and the low-pass that is theirs."""
    rng, low_pass = np.random.default_rng(seed), LowPass(cutoff=41.0)
    given = [np.stack([red_noise(1.0, stays, 500, rng) for _ in range(3)], axis=1) for _ in range(12)]
    above = np.mean([np.var(part - low_pass(part, RARE)) for part in given]) / (1 - 2 * 41.0 * RARE)
    white = [np.sqrt(above) * rng.normal(size=part.shape) for part in given]
    return given, estimate_noise_spectrum(given, given, white, 41.0, low_pass, RARE), low_pass


def test_noise_of_rare_samples_goes_on_into_the_band():
    given, found, low_pass = rare(0.5)
    for j in range(3):
        drawn = low_pass(found.drawn(j, 40_000, np.random.default_rng(2)), RARE)
        expected = np.concatenate([low_pass(part[:, j], RARE) for part in given])
        assert drawn.std() == pytest.approx(expected.std(), rel=0.2)


def test_what_comes_and_goes_above_the_band_of_rare_samples_is_no_noise():
    """Pulses that a model lacks are heard above the band, too, but not where the log is quiet."""
    rng, low_pass = np.random.default_rng(5), LowPass(cutoff=41.0)
    pulses = [rng.normal(size=(500, 1)) for _ in range(12)]
    quiet = [1e-2 * rng.normal(size=part.shape) for part in pulses]
    left = [a + b for a, b in zip(pulses, quiet, strict=True)]
    assert estimate_noise_spectrum(left, left, quiet, 41.0, low_pass, RARE).is_white


def test_white_noise_of_rare_samples_stays_as_loud_as_it_is():
    for seed in range(5):
        given, found, low_pass = rare(0.0, seed)
        for j in np.flatnonzero(found.fresh):
            drawn = low_pass(found.drawn(j, 40_000, np.random.default_rng(2)), RARE)
            expected = np.concatenate([low_pass(part[:, j], RARE) for part in given])
            assert drawn.std() == pytest.approx(expected.std(), rel=0.2)


def test_noise_that_falls_is_no_more_than_what_a_model_leaves():
    """Colour above the band, and a model that follows it within."""
    given = noise(STAYS)
    followed = [part - LowPass(cutoff=40.0)(part, DT) for part in given]
    most, least = colour(given), colour(given, followed)
    assert np.all(least.stays < most.stays)


@pytest.mark.slow
@pytest.mark.parametrize("columns", [(), ("reference", "feedback")])
def test_nothing_is_found_in_coloured_noise_but_a_fault_is(columns, one_axis):
    rng = np.random.default_rng(7)
    references = [sines(one_axis, phase, 8.0) for phase in (0.0, 1.5)]
    logs = [
        recorded(one_axis, reference, noise=(2e-5, 0.02), rng=rng, coloured=STAYS, columns=columns)
        for reference in references
    ]
    found = diagnose(one_axis, logs)
    assert found.verdict == "none", found.sentence
    less = EFFECTS["coulomb_level"].on(one_axis, change=-0.2)
    found = diagnose(Machine(robot=one_axis, effects=(less,)), logs)
    assert [cause.effect for cause in found.causes] == ["coulomb_level"]
    assert 0.8 * (1 + found.causes[0].parameters[0].value) == pytest.approx(1.0, abs=0.02)
