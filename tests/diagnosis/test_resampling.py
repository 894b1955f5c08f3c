"""Intervals and folds from blocks of rows: intervals are as often right as they say, where rows are correlated too."""

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.diagnosis.resampling import Blocks, Pool, bootstrap, cut_blocks, intervals, make_motion_folds
from ffgym.logs.quality.signals import stretches


def of_two_records(n_rows=1200, cut=700):
    return [np.arange(n_rows) < cut, np.arange(n_rows) > cut]


def test_blocks_share_no_row_do_not_reach_over_strata_and_leave_out_other_rows():
    blocks = Blocks.cut(of_two_records(), dt=0.01, duration=1.0)
    assert blocks.n_blocks == 7 + 5
    np.testing.assert_array_equal(np.bincount(blocks.of_row[:700]), np.full(7, 100))
    assert blocks.of_row[700] == -1
    assert set(blocks.of_row[701:]) == set(range(7, 12))
    np.testing.assert_array_equal(blocks.stratum, [0] * 7 + [1] * 5)
    values = np.random.default_rng(0).normal(size=(1200, 2))
    np.testing.assert_allclose(blocks.sums(values).sum(axis=0), values.sum(axis=0) - values[700])


def test_joined_blocks_keep_their_records_apart():
    one = Blocks.cut(of_two_records(), dt=0.01, duration=1.0)
    both = Blocks.joined([one, one])
    assert both.n_blocks == 2 * one.n_blocks
    assert len(both.of_row) == 2 * len(one.of_row)
    assert (both.of_row == -1).sum() == 2
    np.testing.assert_array_equal(np.unique(both.stratum), np.arange(4))


def test_a_resample_draws_within_strata_and_loses_none():
    blocks, rng = Blocks.cut(of_two_records(), dt=0.01, duration=1.0), np.random.default_rng(0)
    draws = np.stack([blocks.draw(rng) for _ in range(2000)])
    np.testing.assert_allclose(draws[:, :7].sum(axis=1), 7)
    np.testing.assert_allclose(draws[:, 7:].sum(axis=1), 5)
    np.testing.assert_allclose(draws.mean(axis=0), 1, atol=0.08)


def test_the_spread_of_a_mean_of_few_blocks_is_not_too_small():
    rng = np.random.default_rng(1)
    blocks = Blocks.cut([np.ones(400, dtype=np.bool_)], dt=0.01, duration=1.0)
    spreads = []
    for _ in range(300):
        sums = blocks.sums(rng.normal(size=400))
        spreads.append(bootstrap(lambda counts, s=sums: np.atleast_1d(counts @ s / 400), blocks, rng, 60).var())
    assert np.mean(spreads) == pytest.approx(1 / 400, rel=0.1)


def test_a_pool_draws_as_many_blocks_as_it_has_and_spreads_as_they_do():
    rng, values = np.random.default_rng(3), np.random.default_rng(4).normal(size=200)
    draws = bootstrap(lambda counts: counts, Pool(200), rng, 1000)
    np.testing.assert_array_equal(draws.sum(axis=1), 200)
    assert (draws @ values / 200).std() == pytest.approx(values.std() / np.sqrt(200), rel=0.1)


def test_each_motion_is_left_out_once_in_folds_of_motions_or_of_groups_of_them():
    blocks = cut_blocks(np.ones((300, 5), dtype=np.bool_), 0.01)
    for count, n_folds in ((None, 5), (2, 2), (9, 5)):
        folds = make_motion_folds(blocks, count)
        assert len(folds) == n_folds
        np.testing.assert_array_equal(np.sum([fold.test for fold in folds], axis=0), 1)
        assert all(set(blocks.motion[fold.test]).isdisjoint(blocks.motion[fold.train]) for fold in folds)
    assert make_motion_folds(cut_blocks(np.ones((300, 1), dtype=np.bool_), 0.01)) == []


def test_intervals_of_a_correlated_mean_are_as_often_right_as_they_say():
    rng, right, n_rows = np.random.default_rng(2), 0, 6000
    blocks = Blocks.cut([np.ones(n_rows, dtype=np.bool_)], dt=0.001, duration=0.2)
    for _ in range(200):
        noise = np.convolve(rng.normal(size=n_rows + 19), np.ones(20), mode="valid")  # correlated over 20 rows
        sums = blocks.sums(noise) / n_rows
        found = np.atleast_1d(sums.sum())
        spread = bootstrap(lambda counts, s=sums: np.atleast_1d(counts @ s), blocks, rng, 200)
        interval = intervals(found, spread)
        right += bool(interval.low[0] <= 0 <= interval.high[0])
    assert 0.83 <= right / 200 <= 0.96


def test_same_seed_same_intervals_and_the_estimate_is_inside():
    blocks = Blocks.cut(of_two_records(), dt=0.01, duration=1.0)
    sums = blocks.sums(np.arange(1200.0))

    def estimate(counts):
        return np.array([counts @ sums, counts.max()])

    once, again = (bootstrap(estimate, blocks, np.random.default_rng(5), 50) for _ in range(2))
    np.testing.assert_array_equal(once, again)
    interval = intervals(estimate(np.ones(12)), once)
    assert (interval.low <= estimate(np.ones(12))).all()
    assert (interval.high >= estimate(np.ones(12))).all()


def test_a_widened_interval_reaches_further_on_both_sides():
    resampled = np.linspace(0.0, 1.0, 101)[:, None]
    plain, wide = (intervals(np.array([0.25]), resampled, widened=widened) for widened in (1.0, 1.5))
    assert (plain.low[0], plain.high[0]) == pytest.approx((0.05, 0.95))
    assert (wide.low[0], wide.high[0]) == pytest.approx((0.25 - 1.5 * 0.2, 0.25 + 1.5 * 0.7))


def test_runs_are_found_at_the_ends_too():
    assert stretches(np.array([True, True, False, True])) == [slice(0, 2), slice(3, 4)]
    assert stretches(np.zeros(3, dtype=np.bool_)) == []


def test_no_rows_are_refused():
    with pytest.raises(FFGymError, match="no rows to estimate from"):
        Blocks.cut([np.zeros(5, dtype=np.bool_)], dt=0.01, duration=1.0)
