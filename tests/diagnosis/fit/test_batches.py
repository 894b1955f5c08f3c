"""The search whose candidates run side by side goes down as far as it is told, and goes on where it was stopped."""

import json

import numpy as np
import pytest

from ffgym.diagnosis.fit.batches import DAMPINGS, Descent

STEP = 2.0**-10
"""A step of finite differences without rounding."""


def descent(clip=lambda x: x):
    def evaluate(xs):
        return [(None, np.array([10 * (x[1] - x[0] ** 2), 1 - x[0]])) for x in xs]

    return Descent(evaluate=evaluate, steps=np.full(2, 1e-4), spread=np.ones(2), clip=clip)


def linear(matrix, measured, spread, dampings=(1.0,), seen=None):
    """Search for the numbers of a linear model; candidates are kept in `seen`."""
    matrix, measured = np.array(matrix), np.array(measured)

    def evaluate(xs):
        if seen is not None:
            seen.extend(xs.tolist())
        return [(float(x.sum()), matrix @ x - measured) for x in xs]

    spread = np.array(spread)
    return Descent(
        evaluate=evaluate, steps=np.full(len(spread), STEP), spread=spread, clip=lambda x: x, dampings=dampings
    )


def halving(seen=None):
    """A search that halves its one number with each step: its damping is as stiff as its model."""
    return linear([[1.0]], [0.0], [1.0], seen=seen)


def test_it_comes_down_a_curved_valley():
    search = descent()
    *_, last = search.descend(search.points(np.zeros((1, 2)), 1.0)[0], 60)
    np.testing.assert_allclose(last.x, 1.0, atol=1e-3)


def test_it_stays_within_bounds():
    search = descent(lambda x: np.clip(x, -0.5, 0.5))
    *_, last = search.descend(search.points(np.zeros((1, 2)), 1.0)[0], 60)
    assert np.all(np.abs(last.x) <= 0.5)
    assert last.cost < 1


def test_a_step_is_damped_by_the_spread_of_each_number():
    """A number that may be far off is held less: with residuals 2 x - 6 and x - 1, and spreads of 2 and 1/2."""
    search = linear([[2.0, 0.0], [0.0, 1.0]], [6.0, 1.0], [2.0, 0.5])
    (begun,) = search.points(np.zeros((1, 2)), 3.0)
    assert (begun.steps, begun.rests) == (0, False)
    np.testing.assert_allclose(search.jacobian(begun), [[2.0, 0.0], [0.0, 1.0]])
    (found,) = search.descend(begun, 1)
    np.testing.assert_allclose(found.x, [12 / (4 + 3 / 4), 1 / (1 + 3 * 4)])


def test_slopes_are_of_each_number_by_its_own_step():
    search = Descent(
        evaluate=lambda xs: [(None, np.array([x[0] ** 2, x[1] ** 2, x[0] * x[1]])) for x in xs],
        steps=np.array([0.5, 0.25]),
        spread=np.ones(2),
        clip=lambda x: x,
    )
    (point,) = search.points(np.array([[1.0, 2.0]]), 1.0)
    np.testing.assert_allclose(search.jacobian(point), [[2.5, 0.0], [0.0, 4.25], [2.0, 1.0]])


def test_the_damping_of_a_step_is_a_factor_on_that_of_the_last():
    search = linear([[1.0]], [0.0], [1.0], dampings=(0.5,))
    points = list(search.descend(search.points(np.ones((1, 1)), 1.0)[0], 3))
    assert [point.damping for point in points] == [0.5, 0.25, 0.125]
    np.testing.assert_allclose([point.x[0] for point in points], np.cumprod([0.5 / 1.5, 0.25 / 1.25, 0.125 / 1.125]))
    assert points[0].outcome == pytest.approx(1 / 3)


def test_the_best_of_several_dampings_is_taken():
    search = linear([[1.0]], [0.0], [1.0], dampings=(4.0, 0.25, 1.0))
    (found,) = search.descend(search.points(np.ones((1, 1)), 1.0)[0], 1)
    assert found.damping == 0.25


def test_dampings_that_are_tried_reach_far_both_ways_without_a_gap():
    factors = np.array(DAMPINGS)
    assert np.all(factors > 0)
    assert np.all((factors[1:] > factors[:-1]) & (factors[1:] < 4 * factors[:-1]))
    assert factors[0] < 0.1
    assert factors[-1] >= 10.0


def test_it_ends_after_the_first_step_that_lowers_the_cost_by_less_than_a_share():
    """Each step leaves a quarter."""

    def points(gain, most=3):
        search = halving()
        return list(search.descend(search.points(np.ones((1, 1)), 1.0)[0], most, gain))

    assert [(point.steps, point.rests) for point in points(0.75)] == [(1, False), (2, False), (3, False)]
    assert [(point.steps, point.rests) for point in points(0.76)] == [(1, True)]
    assert [point.cost for point in points(0.0, most=2)] == [1 / 4, 1 / 16]


def test_where_no_step_is_better_there_is_none():
    search = linear([[0.0]], [1.0], [1.0])  # the number changes nothing
    assert list(search.descend(search.points(np.ones((1, 1)), 1.0)[0], 5)) == []


def test_each_candidate_has_an_outcome():
    search = Descent(evaluate=lambda xs: [], steps=np.ones(1), spread=np.ones(1), clip=lambda x: x)
    with pytest.raises(ValueError, match="shorter"):
        search.points(np.ones((2, 1)), 1.0)


def test_a_search_begins_at_the_best_of_its_starts_and_keeps_every_point():
    kept = []
    found = halving().search(np.array([[8.0], [4.0], [-6.0]]), 2, kept.append, {})
    assert [(float(point.x[0]), point.damping, point.steps, point.rests) for point in kept] == [
        (4.0, 1.0, 0, False),
        (2.0, 1.0, 1, False),
        (1.0, 1.0, 2, False),
    ]
    assert found is kept[-1]


def test_a_search_that_was_stopped_goes_on_as_if_it_had_not_been():
    """From the state of its last point, by way of a JSON file; steps before it count."""

    def search(most, state):
        return linear([[1.0], [2.0]], [1.0, 3.0], [1.0], DAMPINGS).search(np.ones((1, 1)), most, kept.append, state)

    kept = []
    stopped = search(2, {})
    state = json.loads(json.dumps(stopped.state))
    resumed, whole = search(3, state), search(3, {})
    assert resumed.steps == whole.steps == 3
    assert resumed.damping == whole.damping
    np.testing.assert_array_equal(resumed.x, whole.x)
    assert [point.steps for point in kept] == [0, 1, 2, 2, 3, 0, 1, 2, 3]
    assert search(2, state).steps == 2  # there are no steps left
    assert search(9, state | {"rests": True}).steps == 2  # another step was not worth it


def test_the_share_that_ends_a_search_is_that_of_its_steps():
    kept = []
    assert halving().search(np.ones((1, 1)), 5, kept.append, {}, gain=0.8).rests
    assert len(kept) == 2


def test_without_free_numbers_there_is_one_simulation():
    seen, kept = [], []
    search = linear(np.zeros((2, 0)), [1.0, 2.0], [], seen=seen)
    found = search.search(np.zeros((1, 0)), 5, kept.append, {})
    assert (found.cost, len(kept), len(seen)) == (5.0, 1, 1)
    assert search.jacobian(found).shape == (2, 0)
