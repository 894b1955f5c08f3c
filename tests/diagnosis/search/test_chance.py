"""Faultless logs: noise in ever new order, and the score that chance reaches."""

import numpy as np
import pytest
from scipy import stats

from ffgym.diagnosis.resampling import cut_blocks
from ffgym.diagnosis.search.candidates import draw_surrogates
from ffgym.diagnosis.search.ranking import _estimate_extreme
from ffgym.diagnosis.settings import settings

ROW_DT = 0.01


def made(prior=()):
    rng = np.random.default_rng(0)
    draws = {"torque": rng.normal(size=(600, 2, 1, 2))}
    valid = np.ones((600, 2), dtype=bool)
    blocks = cut_blocks(valid, ROW_DT)
    return draws, blocks, draw_surrogates(draws, blocks, prior, np.random.default_rng(1))["torque", 0]


def test_each_block_of_a_faultless_log_is_one_of_the_replays_or_its_negative():
    draws, blocks, found = made()
    assert found.shape == (600, 2, settings().screening.surrogates)
    for b in range(len(blocks)):
        rows = blocks.of_row == b
        for k in range(settings().screening.surrogates):
            kinds = [sign * draws["torque"][rows][:, 0, d] for sign in (1, -1) for d in (0, 1)]
            assert any(np.array_equal(found[rows, k], one) for one in kinds)


def test_every_replay_is_drawn_and_blocks_of_a_log_have_signs_of_their_own():
    """Replays of one and the same number each, 1 to 5, show which of them a log took, and with which signs."""
    draws = {"torque": np.broadcast_to(np.arange(1.0, 6.0), (600, 2, 1, 5))}
    blocks = cut_blocks(np.ones((600, 2), dtype=bool), ROW_DT)
    found = draw_surrogates(draws, blocks, (), np.random.default_rng(1))["torque", 0]
    took = np.abs(found[0, 0])
    assert set(took) == {1.0, 2.0, 3.0, 4.0, 5.0}
    assert np.array_equal(np.abs(found), np.broadcast_to(took, found.shape))
    begins = [np.argwhere(blocks.of_row == b)[0] for b in range(len(blocks))]
    signs = np.array([np.sign(found[row, motion]) for row, motion in begins])
    assert 0.45 < np.mean(signs > 0) < 0.55
    assert np.abs(np.corrcoef(signs)[np.triu_indices(len(signs), 1)]).mean() < 0.2


def test_blocks_keep_their_spectrum():
    draws, blocks, found = made()
    rows = blocks.of_row == 0
    known = [np.abs(np.fft.rfft(draws["torque"][rows][:, 0, d])) for d in (0, 1)]
    spectrum = np.abs(np.fft.rfft(found[rows, 7]))
    assert any(np.allclose(spectrum, one) for one in known)


def test_errors_of_calibration_are_drawn_with_their_deviation():
    column = {("torque", 0): np.full((600, 2), 50.0)}
    _, _, without = made()
    _, _, drawn = made([column])
    errors = (drawn - drawn.mean(axis=2, keepdims=True)).mean(axis=(0, 1)) / 50.0
    assert 0.7 < np.std(errors) < 1.3
    assert np.std(without.mean(axis=(0, 1))) < 5.0


def test_chance_exceeds_the_threshold_a_few_times_in_a_thousand():
    """Largest of many scores in each of as many faultless logs as are drawn, and one more."""
    rng = np.random.default_rng(2)
    alarms = 0
    for _ in range(2000):
        largest = rng.chisquare(1, size=(settings().screening.surrogates + 1, 40)).max(axis=1)
        alarms += largest[-1] > _estimate_extreme(largest[:-1])
    assert 0.0005 <= alarms / 2000 < 0.006


@pytest.mark.parametrize(("location", "scale"), [(3.0, 0.5), (0.0, 2.0)])
def test_the_threshold_is_a_quantile_of_largest_values(location, scale):
    largest = stats.gumbel_r(location, scale)
    evenly = largest.ppf((np.arange(200) + 0.5) / 200)
    assert _estimate_extreme(evenly) == pytest.approx(largest.ppf(settings().screening.level), rel=0.02)
