"""The search whose candidates run side by side finds the minimum of a curved valley, within its bounds."""

import numpy as np

from ffgym.diagnosis.fit.batches import Descent


def descent(clip=lambda x: x):
    def evaluate(xs):
        return [(None, np.array([10 * (x[1] - x[0] ** 2), 1 - x[0]])) for x in xs]

    return Descent(evaluate=evaluate, steps=np.full(2, 1e-4), spread=np.ones(2), clip=clip)


def test_it_comes_down_a_curved_valley():
    search = descent()
    *_, last = search.descend(search.points(np.zeros((1, 2)), 1.0)[0], 60)
    np.testing.assert_allclose(last.x, 1.0, atol=1e-3)


def test_it_stays_within_bounds():
    search = descent(lambda x: np.clip(x, -0.5, 0.5))
    *_, last = search.descend(search.points(np.zeros((1, 2)), 1.0)[0], 60)
    assert np.all(np.abs(last.x) <= 0.5)
    assert last.cost < 1
