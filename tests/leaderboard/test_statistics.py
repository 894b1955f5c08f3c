import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from ffgym.core.errors import FFGymError
from ffgym.leaderboard.comparison.statistics import (
    Interval,
    difference,
    draw_resamples,
    interquartile_mean,
    interval,
    resample_iqms,
    resample_means,
)

numbers = st.lists(st.floats(-1e3, 1e3), min_size=1, max_size=40)


@given(numbers)
def test_an_interquartile_mean_is_scipys_mean_trimmed_by_a_quarter(values):
    assert interquartile_mean(np.array(values)) == pytest.approx(stats.trim_mean(values, 0.25), abs=1e-9)


@given(numbers, st.randoms())
def test_an_interquartile_mean_does_not_depend_on_order(values, random):
    shuffled = random.sample(values, len(values))
    assert interquartile_mean(np.array(values)) == interquartile_mean(np.array(shuffled))


@given(numbers, st.floats(0.1, 10), st.floats(-10, 10))
def test_an_interquartile_mean_scales_and_shifts_with_its_values(values, scale, shift):
    expected = scale * interquartile_mean(np.array(values)) + shift
    assert interquartile_mean(scale * np.array(values) + shift) == pytest.approx(expected, abs=1e-7)


def test_what_is_no_number_counts_as_the_worst_and_is_never_dropped():
    few, many = np.array([1.0, 2.0, 3.0, np.nan]), np.array([1.0, 2.0, np.nan, np.nan])
    assert interquartile_mean(few) == 2.5
    assert interquartile_mean(many) == np.inf


def test_an_interquartile_mean_of_nothing_is_refused():
    with pytest.raises(FFGymError, match="at least one value"):
        interquartile_mean(np.array([]))


def spelled_out(values, by, statistic):
    """The statistic in every resample, with every value written down as often as it was taken."""
    seeds = [np.repeat(np.arange(len(counts)), counts) for counts in by.seeds]
    plants = [np.repeat(np.arange(len(counts)), counts) for counts in by.plants]
    return np.array([statistic(values[np.ix_(s, p)]) for s, p in zip(seeds, plants, strict=True)])


@pytest.mark.parametrize("shape", [(5, 3, 7), (1, 4, 2), (3, 1, 1), (1, 1, 4)])
def test_resampled_statistics_are_those_of_the_values_that_were_taken(shape):
    values = np.random.default_rng(3).lognormal(size=shape)
    by = draw_resamples("someone", *shape[:2], count=50)
    np.testing.assert_allclose(resample_iqms(values, by), spelled_out(values, by, interquartile_mean), rtol=1e-12)
    np.testing.assert_allclose(resample_means(values, by), spelled_out(values, by, np.mean), rtol=1e-12)


def test_a_resample_that_takes_stopped_robots_is_as_bad_as_they_are():
    values = np.random.default_rng(4).lognormal(size=(4, 2, 3))
    values[1] = np.inf
    by = draw_resamples("someone", 4, 2, count=60)
    np.testing.assert_allclose(resample_iqms(values, by), spelled_out(values, by, interquartile_mean), rtol=1e-12)
    assert np.isinf(resample_means(values, by)).tolist() == (by.seeds[:, 1] > 0).tolist()
    assert np.isinf(resample_iqms(np.full((4, 2, 3), np.inf), by)).all()
    alone = draw_resamples("someone", 4, 1, count=60)
    assert np.isinf(resample_means(values[:, :1], alone)).tolist() == (alone.seeds[:, 1] > 0).tolist()


def test_rows_share_plants_but_not_seeds_and_a_name_always_gives_the_same():
    one, other = draw_resamples("one", 5, 6), draw_resamples("other", 5, 6)
    np.testing.assert_array_equal(one.plants, other.plants)
    assert (one.seeds != other.seeds).any()
    np.testing.assert_array_equal(one.seeds, draw_resamples.__wrapped__("one", 5, 6).seeds)


def test_two_that_stopped_do_not_differ():
    assert difference(np.array([np.inf, np.inf, 2.0]), np.array([np.inf, 1.0, 1.0])).tolist() == [0.0, np.inf, 1.0]


def test_nothing_random_has_no_interval():
    assert interval(np.ones(10), 1) is None


def test_an_interval_includes_its_ends():
    assert Interval(-1.0, 0.0).includes(0.0)
    assert not Interval(0.1, 1.0).includes(0.0)


def covered(statistic, resampled, n_seeds, n_plants, experiments=250):
    """Share of experiments whose interval holds 0, the true centre; seeds and plants shift all cells alike."""
    rng = np.random.default_rng(8)
    cells = np.linspace(-2, 2, 12)
    held = 0
    for k in range(experiments):
        shifts = (n_seeds > 1) * rng.normal(size=(n_seeds, 1, 1)) + (n_plants > 1) * rng.normal(size=(1, n_plants, 1))
        values = cells + shifts + 0.3 * rng.normal(size=(n_seeds, n_plants, len(cells)))
        by = draw_resamples(str(k), n_seeds, n_plants, count=300)
        found = interval(resampled(values, by), by.levels)
        held += found.includes(0.0)
    return held / experiments


@pytest.mark.parametrize(("n_seeds", "n_plants"), [(5, 1), (1, 20), (5, 20)])
def test_intervals_hold_the_truth_about_as_often_as_they_say(n_seeds, n_plants):
    means = covered(np.mean, resample_means, n_seeds, n_plants)
    iqms = covered(interquartile_mean, resample_iqms, n_seeds, n_plants)
    assert 0.90 <= means <= 0.995
    assert 0.90 <= iqms <= 0.995


def test_seeds_drawn_anew_in_every_cell_would_claim_too_much():
    """Why resamples take the same seeds in every cell, which departs from the reference."""
    rng = np.random.default_rng(9)
    held = 0
    for _ in range(200):
        values = rng.normal(0, 1, (5, 1)) + 0.3 * rng.normal(size=(5, 12))
        taken = rng.integers(5, size=(400, 5, 12))
        means = values[taken, np.arange(12)].mean(axis=(1, 2))
        held += interval(means, 5).includes(0.0)
    assert held / 200 < 0.75


@pytest.mark.parametrize(("levels", "t"), [(2, 12.706205), (5, 2.776445), (20, 2.093024)])
def test_percentiles_are_expanded_as_far_as_students_t_reaches_beyond_the_normal(levels, t):
    """Two-sided 95 % quantiles of t with levels - 1 degrees of freedom, by its tables."""
    samples = np.random.default_rng(0).permutation(np.arange(200_001) / 200_000)
    tail = stats.norm.cdf(-t * np.sqrt(levels / (levels - 1)))
    found = interval(samples, levels)
    assert (found.low, found.high) == pytest.approx((tail, 1 - tail), abs=1e-5)


def test_the_ends_of_an_interval_are_in_it():
    one = Interval(1.0, 2.0)
    assert [one.includes(value) for value in (0.99, 1.0, 1.5, 2.0, 2.01)] == [False, True, True, True, False]


@pytest.mark.parametrize(("n_seeds", "n_plants", "levels"), [(1, 1, 1), (2, 1, 2), (1, 5, 5), (3, 2, 2), (2, 7, 2)])
def test_levels_are_the_fewest_of_a_factor_that_has_more_than_one(n_seeds, n_plants, levels):
    assert draw_resamples("a", n_seeds, n_plants, 10).levels == levels
