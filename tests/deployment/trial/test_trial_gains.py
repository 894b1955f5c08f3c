"""Gains from pairs of errors: values by hand, and claims that are made as seldom by chance as they should be."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
import scipy
from hypothesis import given
from hypothesis import strategies as st

from ffgym.core.errors import FFGymError
from ffgym.deployment.trial.gains import OVERALL, adjust_by_holm, estimate_gains
from ffgym.deployment.trial.power import (
    compute_power,
    count_least_pairs,
    count_pairs,
    find_least_gain,
    pool_pilot,
)


def draw_pairs(rng: np.random.Generator, count: int, gain: float, spread: float) -> np.ndarray:
    """Errors of pairs, shape (count, 2), with a gain and a spread of their ratios."""
    errors = np.exp(rng.normal(scale=spread / np.sqrt(2), size=(count, 2)))
    return errors * [1.0, 1.0 - gain]


def test_the_interval_of_one_place_is_that_of_the_paired_t_test_and_p_counts_signs():
    errors = draw_pairs(np.random.default_rng(0), 8, 0.3, 0.1)
    (gain,) = estimate_gains({"a": errors})
    ratios = np.log(errors[:, 1] / errors[:, 0])
    low, high = scipy.stats.ttest_1samp(ratios, 0.0).confidence_interval(0.95)
    assert np.allclose([gain.gain, gain.low, gain.high], 1 - np.exp([ratios.mean(), high, low]))
    assert gain.p == 2 / 2**8
    assert gain.claim == "gain"
    assert gain.without == pytest.approx(scipy.stats.gmean(errors[:, 0]))


def test_p_is_the_share_of_throws_of_the_coins_that_are_as_far_from_zero():
    errors = draw_pairs(np.random.default_rng(8), 6, 0.02, 0.05)
    (gain,) = estimate_gains({"a": errors})
    ratios = np.log(errors[:, 1] / errors[:, 0])
    throws = np.array([np.dot(signs, ratios) for signs in product((1, -1), repeat=6)])
    assert gain.p == pytest.approx(np.mean(np.abs(throws) >= abs(ratios.sum()) - 1e-12))
    assert 0.05 < gain.p < 0.9


def test_a_correction_that_harms_is_called_worse():
    (gain,) = estimate_gains({"a": draw_pairs(np.random.default_rng(0), 8, -0.2, 0.05)})
    assert gain.claim == "worse"
    assert gain.gain < 0 < gain.spread


def test_over_all_places_count_alike_however_many_pairs_are_left_of_each():
    rng = np.random.default_rng(0)
    errors = {"a": draw_pairs(rng, 12, 0.5, 1e-6), "b": draw_pairs(rng, 4, 0.2, 1e-6)}
    whole = estimate_gains(errors)[-1]
    assert whole.name == OVERALL
    assert whole.gain == pytest.approx(1 - np.sqrt(0.5 * 0.8), abs=1e-5)
    assert whole.pairs == 16


def test_the_interval_over_all_has_the_freedom_of_unequal_places():
    rng = np.random.default_rng(3)
    errors = {"a": draw_pairs(rng, 7, 0.0, 0.1), "b": draw_pairs(rng, 5, 0.0, 0.01)}
    whole = estimate_gains(errors)[-1]
    ratios = [np.log(own[:, 1] / own[:, 0]) for own in errors.values()]
    # half the difference of one and the negative of the other: Welch's interval of scipy
    low, high = scipy.stats.ttest_ind(ratios[0], -ratios[1], equal_var=False).confidence_interval(0.95)
    assert np.allclose([whole.low, whole.high], 1 - np.exp([high / 2, low / 2]))


def test_over_all_places_count_alike_in_the_throws_of_the_coins_too():
    rng = np.random.default_rng(4)
    errors = {"a": draw_pairs(rng, 4, 0.1, 0.1), "b": draw_pairs(rng, 2, 0.0, 0.1)}
    ratios = [np.log(own[:, 1] / own[:, 0]) / len(own) for own in errors.values()]
    throws = np.array([np.dot(signs, np.concatenate(ratios)) for signs in product((1, -1), repeat=6)])
    whole = estimate_gains(errors)[-1]
    assert whole.p == pytest.approx(np.mean(np.abs(throws) >= abs(np.concatenate(ratios).sum()) - 1e-12))


def test_a_gain_whose_interval_holds_zero_is_not_claimed_though_its_p_value_is_small():
    (gain,) = estimate_gains({"a": draw_pairs(np.random.default_rng(0), 8, 0.3, 0.1)})
    assert gain.claim == "gain"
    assert replace(gain, low=-0.01).claim == "none"
    assert replace(gain, p_adjusted=0.051).claim == "none"


def test_holm_holds_each_p_value_to_the_claims_that_are_left():
    assert adjust_by_holm([0.02, 0.01, 0.025]) == pytest.approx([0.04, 0.03, 0.04])


def test_with_few_pairs_nothing_is_claimed_however_large_the_gain():
    (gain,) = estimate_gains({"a": draw_pairs(np.random.default_rng(0), 5, 0.9, 0.01)})
    assert gain.p == 2 / 2**5
    assert gain.low > 0.8
    assert gain.claim == "none"
    (one,) = estimate_gains({"a": np.array([[1.0, 0.5]])})
    assert (one.claim, one.gain, one.p) == ("too few", 0.5, 1.0)
    (none,) = estimate_gains({"a": np.empty((0, 2))})
    assert (none.claim, none.pairs) == ("too few", 0)


def test_a_place_without_a_spread_does_not_hide_the_whole():
    rng = np.random.default_rng(0)
    gains = estimate_gains({"a": draw_pairs(rng, 8, 0.3, 0.02), "b": draw_pairs(rng, 1, 0.3, 0.02)})
    assert [gain.claim for gain in gains] == ["gain", "too few", "gain"]


@given(st.lists(st.floats(0.0, 1.0), min_size=1, max_size=6))
def test_adjusted_p_values_are_not_smaller_and_keep_their_order(p):
    adjusted = adjust_by_holm(p)
    assert all(a >= b for a, b in zip(adjusted, p, strict=True))
    assert max(adjusted) <= 1.0
    order = np.argsort(p, kind="stable")
    assert np.all(np.diff(np.array(adjusted)[order]) >= 0)
    assert adjusted[order[0]] == pytest.approx(min(1.0, len(p) * min(p)))


def test_where_nothing_is_gained_a_claim_is_made_in_at_most_one_of_twenty_while_the_machine_drifts():
    rng, claims, covered, count = np.random.default_rng(5), 0, 0, 300
    for _ in range(count):
        # a machine that warms up: errors fall by a third over the first pairs, and repeat to 2 %
        times = np.arange(7)[:, None] + np.where(rng.random((7, 1)) < 0.5, [[0.0, 0.5]], [[0.5, 0.0]])
        errors = np.exp(0.3 * np.exp(-times / 3) + 0.02 * rng.standard_normal((7, 2)))
        (gain,) = estimate_gains({"a": errors})
        claims += gain.claim != "none"
        covered += gain.low <= 0 <= gain.high
    assert claims <= scipy.stats.binom.ppf(0.999, count, 0.05)
    assert scipy.stats.binom.ppf(0.001, count, 0.95) <= covered


def test_counted_pairs_show_the_gain_as_often_as_they_should_and_one_less_does_not():
    gain, spread = 0.05, 0.06
    pairs = count_pairs(gain, spread, power=0.8)
    assert compute_power(gain, spread, pairs) >= 0.8 > compute_power(gain, spread, pairs - 1)
    rng = np.random.default_rng(0)
    tests = rng.normal(np.log1p(-gain), spread, size=(4000, pairs))
    shown = scipy.stats.ttest_1samp(tests, 0.0, axis=1).pvalue < 0.05
    assert np.mean(shown) == pytest.approx(compute_power(gain, spread, pairs), abs=0.03)


def test_more_places_need_more_pairs_and_few_pairs_show_nothing():
    assert [count_least_pairs(places) for places in (1, 2, 8)] == [6, 7, 9]
    for places in (1, 2, 8):
        assert count_pairs(0.5, 0.001, places=places) == count_least_pairs(places)
        least = count_least_pairs(places)
        assert (places + (places > 1)) * 2 / 2**least <= 0.05 < (places + (places > 1)) * 2 / 2 ** (least - 1)
    assert count_pairs(0.001, 0.5) is None
    assert find_least_gain(0.05, 5) is None
    least = find_least_gain(0.05, 8)
    assert compute_power(least, 0.05, 8) == pytest.approx(0.9)


def test_a_small_pilot_is_reckoned_with_more_caution_than_a_large_one():
    assert pool_pilot([0.05], [3]) > pool_pilot([0.05], [30]) > 0.05
    assert pool_pilot([0.03, 0.05], [5, 5]) == pool_pilot([np.sqrt((0.03**2 + 0.05**2) / 2)], [10])
    # the bound that the spread keeps below with a probability of 80 %
    assert pool_pilot([0.05], [10]) == pytest.approx(0.05 * np.sqrt(10 / scipy.stats.chi2.ppf(0.2, 10)))
    with pytest.raises(FFGymError, match="two pairs or more"):
        pool_pilot([], [])
    with pytest.raises(FFGymError, match="gain"):
        count_pairs(0.0, 0.05)
